//! Messages on a stream: a header with the length, and a body. Whatever lies between two messages is passed over.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::{self, JoinHandle};

use serde_json::Value;

use super::Event;
use super::message::{Incoming, RequestError};

/// Longer messages are refused: eight times the largest file that is read.
const MAX_BODY_BYTES: u64 = 8 * crate::source::MAX_FILE_BYTES;

/// No header is as long as this.
const MAX_LINE_BYTES: u64 = 16 * 1024;

const LENGTH: &[u8] = b"content-length:";

/// Reads messages on a thread of its own, until the stream ends.
pub(super) fn read_from(input: impl Read + Send + 'static, events: Sender<Event>) {
    thread::spawn(move || {
        let mut input = BufReader::new(input);
        loop {
            let message = read(&mut input).unwrap_or(Incoming::End);
            let is_end = message == Incoming::End;
            if events.send(Event::Incoming(message)).is_err() || is_end {
                return;
            }
        }
    });
}

/// Writes messages on a thread of its own, so that a client that does not read keeps nobody waiting.
pub(super) fn write_to(output: impl Write + Send + 'static) -> (Sender<Value>, JoinHandle<()>) {
    let (sender, messages): (Sender<Value>, Receiver<Value>) = mpsc::channel();
    let writer = thread::spawn(move || {
        let mut output = output;
        for message in messages {
            let body = message.to_string();
            let header = format!("Content-Length: {}\r\n\r\n", body.len());
            let written = output.write_all(header.as_bytes()).and_then(|()| output.write_all(body.as_bytes()));
            if written.and_then(|()| output.flush()).is_err() {
                return;
            }
        }
    });
    (sender, writer)
}

/// The next message of the stream.
fn read(input: &mut impl BufRead) -> io::Result<Incoming> {
    let mut length: Option<u64> = None;
    let mut line = Vec::new();
    loop {
        line.clear();
        let read = input.by_ref().take(MAX_LINE_BYTES).read_until(b'\n', &mut line)? as u64;
        // A line that has no end is the last one, unless it is too long.
        if read < MAX_LINE_BYTES && !line.ends_with(b"\n") {
            return Ok(Incoming::End);
        }
        let header = line.trim_ascii();
        if let Some(value) = length_in(header) {
            let Some(value) = str::from_utf8(value).ok().and_then(|value| value.trim().parse().ok()) else {
                return Ok(Incoming::invalid(RequestError::PARSE_ERROR, "the length of the message is no number"));
            };
            length = Some(value);
        }
        // An empty line without a length before it belongs to no message.
        if let (true, Some(length)) = (header.is_empty(), length) {
            return body(input, length);
        }
    }
}

/// What stands behind `Content-Length:`, wherever that begins: a body that was longer than it said may stand before it.
fn length_in(line: &[u8]) -> Option<&[u8]> {
    let at = line.windows(LENGTH.len()).rposition(|window| window.eq_ignore_ascii_case(LENGTH))?;
    Some(&line[at + LENGTH.len()..])
}

fn body(input: &mut impl BufRead, length: u64) -> io::Result<Incoming> {
    if length > MAX_BODY_BYTES {
        io::copy(&mut input.by_ref().take(length), &mut io::sink())?;
        let message = format!("the message is too long ({length} bytes, limit {MAX_BODY_BYTES})");
        return Ok(Incoming::invalid(RequestError::INVALID_REQUEST, message));
    }
    let mut body = Vec::new();
    // The length is the client's word: no room is made before the bytes are there.
    let read = input.by_ref().take(length).read_to_end(&mut body)?;
    Ok(if read as u64 == length { Incoming::read(&body) } else { Incoming::End })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(body: &str) -> String {
        format!("Content-Length: {}\r\n\r\n{body}", body.len())
    }

    #[track_caller]
    fn check(stream: &str, expected: &[&str]) {
        let mut input = stream.as_bytes();
        let mut seen = Vec::new();
        loop {
            seen.push(match read(&mut input).unwrap() {
                Incoming::Notification { method, .. } => method,
                Incoming::Invalid { error, .. } => error.code.to_string(),
                Incoming::End => break,
                other => panic!("{other:?}"),
            });
        }
        assert_eq!(seen, expected);
    }

    #[test]
    fn messages_are_read_one_by_one() {
        let second = "content-type: utf-8\r\ncontent-length:14\n\n{\"method\":\"b\"}";
        check(&(frame(r#"{"method":"a"}"#) + second), &["a", "b"]);
    }

    #[test]
    fn garbage_is_passed_over() {
        let next = frame(r#"{"method":"next"}"#);
        check(&format!("hello\r\n\r\n\r\n{next}"), &["next"]);
        check(&format!("hello{next}"), &["next"]);
        check(&format!("Content-Length: x\r\n\r\n{next}"), &["-32700", "next"]);
        check(&format!("Content-Length: -1\r\n\r\n{next}"), &["-32700", "next"]);
        check(&format!("{}{next}", frame("{]")), &["-32700", "next"]);
        // The body is longer than it says.
        check(&format!("Content-Length: 3\r\n\r\n{{\"method\":\"a\"}}{next}"), &["-32700", "next"]);
    }

    #[test]
    fn a_stream_may_end_anywhere() {
        let whole = frame(r#"{"method":"a"}"#);
        for end in 0..whole.len() {
            check(&whole[..end], &[]);
        }
        check("Content-Length: 99999999999999\r\n\r\n{}", &["-32600"]);
    }
}
