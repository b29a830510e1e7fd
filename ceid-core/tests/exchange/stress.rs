//! A writer and a reader in two threads, at full speed: nothing is torn, nothing goes back, the last value arrives.

use crate::WithEveryExchange;
use ceid_core::TransactionIo;
use ceid_core::exchange::{Exchange, ExchangeCell, Read, Reading, Write};
use std::thread;

/// How often: contended locks are much slower than `Latest`.
fn rounds(exchange: &str) -> u64 {
    if exchange == "Latest" { 400_000 } else { 20_000 }
}

/// Long enough to be copied in several steps.
type Value = [u64; 8];

/// The number in a value, all of whose parts have to be alike.
fn number(value: &Value, exchange: &str) -> u64 {
    assert!(value.iter().all(|part| *part == value[0]), "{exchange}: torn: {value:?}");
    value[0]
}

struct OneWay;

impl WithEveryExchange for OneWay {
    fn test<X: Exchange + 'static>(&self, exchange: &str) {
        let rounds = rounds(exchange);
        let mut cell = X::Cell::<Value>::new([0; 8]);
        let (mut writer, mut reader) = cell.split();
        thread::scope(|scope| {
            scope.spawn(move || (1..=rounds).for_each(|n| writer.set([n; 8])));
            scope.spawn(move || {
                let mut last = 0;
                while last < rounds {
                    match reader.get() {
                        Reading::Fresh(value) => {
                            let n = number(&value, exchange);
                            assert!(n > last, "{exchange}: {n} after {last}");
                            last = n;
                        }
                        Reading::Stale(value) => {
                            assert_eq!(number(&value, exchange), last, "{exchange}: changed, and called stale");
                            thread::yield_now();
                        }
                    }
                }
                assert_eq!(reader.get(), Reading::Stale([rounds; 8]), "{exchange}");
            });
        });
    }
}

#[test]
fn values_arrive_whole_in_order_and_at_last() {
    OneWay.run();
}

struct Echo;

impl WithEveryExchange for Echo {
    fn test<X: Exchange + 'static>(&self, exchange: &str) {
        let rounds = rounds(exchange) / 20;
        let mut io = TransactionIo::<Value, Value, X>::new([0; 8], [0; 8]);
        let (mut outside, mut inside) = io.split();
        thread::scope(|scope| {
            scope.spawn(move || {
                let mut last = 0;
                while last < rounds {
                    let Some(input) = inside.input().fresh() else {
                        thread::yield_now();
                        continue;
                    };
                    last = number(&input, exchange);
                    inside.set_output([last * 2; 8]);
                }
            });
            // Each input is sent when the output of the one before has come back.
            for n in 1..=rounds {
                outside.set_input([n; 8]);
                let output = loop {
                    if let Some(output) = outside.output().fresh() {
                        break output;
                    }
                    thread::yield_now();
                };
                assert_eq!(number(&output, exchange), n * 2, "{exchange}");
            }
        });
    }
}

#[test]
fn a_transaction_answers_every_input() {
    Echo.run();
}
