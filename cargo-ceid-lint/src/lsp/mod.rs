//! The language server: findings while code is typed. Talks to one client over two streams, and never prints.
//!
//! The messages are read and written here rather than by a crate: what a client sends wrongly is answered and forgotten, where
//! the usual reader ends the program, and a file's address is taken as the client spells it. The tests read every message that
//! is sent with the types that other servers use.

mod actions;
mod check;
mod checking;
mod client;
mod documents;
mod explain;
mod findings;
mod hints;
mod hover;
mod message;
mod protocol;
mod publish;
mod requests;
mod server;
mod settings;
mod text;
mod transport;
mod unit;
mod uri;
mod view;

use std::io::{Read, Write};
use std::sync::mpsc;

use check::{Checked, Checker};
use message::Incoming;
use server::Server;

/// What the main loop waits for.
#[derive(Debug)]
enum Event {
    /// The client said something.
    Incoming(Incoming),
    /// The checking thread is done with what it was given.
    Checked(Checked),
}

/// Serves one client until it says `exit` or hangs up. Answers whether it asked for the shutdown before, as it should.
pub fn serve(input: impl Read + Send + 'static, output: impl Write + Send + 'static) -> bool {
    let (events, inbox) = mpsc::channel();
    transport::read_from(input, events.clone());
    let (outgoing, writer) = transport::write_to(output);
    let checker = Checker::start(events, unit::check);
    let was_shut_down = Server::new(outgoing, checker).run(&inbox);
    // The server is gone, and with it the last sender: the writer ends when everything is written.
    let _ = writer.join();
    was_shut_down
}
