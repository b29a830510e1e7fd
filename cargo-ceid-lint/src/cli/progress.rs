//! What a long run shows of its progress. Nothing else is printed while it is there, and it is gone before anything is.

use std::io::{self, Write};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::Console;
use crate::pipeline::Steps;
use crate::report::{Paint, Style};

/// How long a run takes before it is worth a bar, and how often the bar is drawn: as in cargo.
const FIRST: Duration = Duration::from_millis(500);
const NEXT: Duration = Duration::from_millis(100);

/// The widest bar.
const MOST_COLUMNS: usize = 80;

/// What is shown, until it is dropped.
pub(super) struct Progress(Option<(Sender<()>, JoinHandle<()>)>);

/// How a bar looks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    /// How many columns there are.
    pub(super) width: usize,
    pub(super) style: Style,
}

impl Progress {
    /// Shows the steps of a run that has begun then, where a bar is wanted and when the run turns out to be long.
    pub(super) fn start(console: Console, steps: &Steps, begun: Instant) -> Self {
        let steps = steps.clone();
        Self::show(console, begun, move |look| look.bar(steps.share()))
    }

    /// Shows that cargo is asked, of which nobody can tell how far it is.
    pub(super) fn of_cargo(console: Console, begun: Instant) -> Self {
        Self::show(console, begun, Look::asking)
    }

    fn show(console: Console, begun: Instant, line: impl Fn(Look) -> String + Send + 'static) -> Self {
        let shown = console.progress().and_then(|look| {
            let (end, ended) = mpsc::channel();
            // Without a further thread nothing is shown, and nothing else is lost.
            let thread = thread::Builder::new().spawn(move || draw(look, line, begun, &ended)).ok()?;
            Some((end, thread))
        });
        Self(shown)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((end, thread)) = self.0.take() {
            drop(end);
            let _ = thread.join();
        }
    }
}

fn draw(look: Look, line: impl Fn(Look) -> String, begun: Instant, ended: &Receiver<()>) {
    let mut pause = FIRST.saturating_sub(begun.elapsed());
    let mut shown = String::new();
    while ended.recv_timeout(pause) == Err(RecvTimeoutError::Timeout) {
        let line = line(look);
        if line != shown {
            print(&line);
            shown = line;
        }
        pause = NEXT;
    }
    if !shown.is_empty() {
        print(&look.erasure());
    }
}

/// A closed pipe is no fault of the run.
fn print(text: &str) {
    let mut stream = io::stderr().lock();
    let _ = stream.write_all(text.as_bytes()).and_then(|()| stream.flush());
}

impl Look {
    /// The bar, after which the next text begins at the start of its line; nothing where there is no room.
    fn bar(self, share: f64) -> String {
        const HEAD: &str = "    Checking";
        let percentage = format!("{:3.0}%", (share * 100.0).floor());
        let around = HEAD.len() + " [] ".len() + percentage.len();
        let Some(room) = self.width.min(MOST_COLUMNS).checked_sub(around + 1).filter(|room| *room > 0) else {
            return String::new();
        };
        let done = (room as f64 * share) as usize;
        let bar = if done == 0 { String::new() } else { "=".repeat(done - 1) + ">" };
        format!("{} [{bar:room$}] {percentage}\r", self.style.paint(Paint::Cyan, HEAD))
    }

    /// What is shown in its place while cargo is asked.
    fn asking(self) -> String {
        const HEAD: &str = "   Resolving";
        const REST: &str = " the dependencies with cargo";
        if self.width <= HEAD.len() + REST.len() {
            return String::new();
        }
        format!("{}{REST}\r", self.style.paint(Paint::Cyan, HEAD))
    }

    fn erasure(self) -> String {
        if self.style.color {
            "\x1b[K".to_owned()
        } else {
            format!("{}\r", " ".repeat(self.width.min(MOST_COLUMNS) - 1))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(width: usize, share: f64, expected: &str) {
        assert_eq!(Look { width, style: Style::default() }.bar(share), expected);
    }

    #[test]
    fn bar_fits_the_terminal() {
        check(31, 0.0, "    Checking [          ]   0%\r");
        check(31, 0.5, "    Checking [====>     ]  50%\r");
        check(31, 1.0, "    Checking [=========>] 100%\r");
        check(21, 0.5, "");
        check(0, 0.5, "");
        assert_eq!(Look { width: 500, style: Style::default() }.bar(0.3).len(), MOST_COLUMNS);
    }

    #[test]
    fn what_is_asked_fits_the_terminal() {
        let asking = |width| Look { width, style: Style::default() }.asking();
        assert_eq!(asking(41), "   Resolving the dependencies with cargo\r");
        assert_eq!(asking(40), "");
    }

    #[test]
    fn what_is_erased_is_all_of_it() {
        let look = Look { width: 40, style: Style::default() };
        assert_eq!(look.erasure().len(), look.bar(0.5).len());
    }
}
