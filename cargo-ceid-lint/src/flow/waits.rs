//! Calls that wait, read a clock, or block: known by their paths, never by their names alone.

use super::{LoopId, NodeId};
use crate::source::Span;

/// A call that has to do with time.
#[derive(Clone, Debug)]
pub struct Wait {
    /// What it does.
    pub kind: WaitKind,
    /// What is called, as the source spells it: `thread::sleep`, `clock.elapsed`.
    pub what: String,
    /// The call.
    pub span: Span,
    /// The node before it.
    pub node: NodeId,
    /// The innermost loop around it.
    pub in_loop: Option<LoopId>,
    /// How long one round lasts that waits here, in seconds, if that is constant.
    pub period: Option<f64>,
}

/// What such a call does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WaitKind {
    /// Waits for some time.
    Sleep,
    /// Waits for the next tick of something periodic.
    Tick,
    /// Reads a clock.
    Clock,
    /// Reads or writes something that may take any time.
    Io,
    /// Waits for a lock.
    Lock,
}

/// Functions by their path.
const FUNCTIONS: &[(WaitKind, &[&str])] = &[
    (
        WaitKind::Sleep,
        &[
            "std::thread::sleep",
            "std::thread::sleep_ms",
            "std::thread::sleep_until",
            "std::thread::park",
            "std::thread::park_timeout",
            "tokio::time::sleep",
            "tokio::time::sleep_until",
            "async_std::task::sleep",
            "async_io::Timer::after",
            "smol::Timer::after",
            "futures_timer::Delay::new",
            "spin_sleep::sleep",
            "embassy_time::block_for",
            "embassy_time::Timer::after",
            "embassy_time::Timer::after_secs",
            "embassy_time::Timer::after_millis",
            "embassy_time::Timer::after_micros",
            "embassy_time::Timer::after_nanos",
            "embassy_time::Timer::after_ticks",
            "embassy_time::Timer::at",
            "cortex_m::asm::delay",
            "libc::sleep",
            "libc::usleep",
            "libc::nanosleep",
            "libc::clock_nanosleep",
        ],
    ),
    (
        WaitKind::Clock,
        &[
            "std::time::Instant::now",
            "std::time::SystemTime::now",
            "tokio::time::Instant::now",
            "embassy_time::Instant::now",
            "chrono::Utc::now",
            "chrono::Local::now",
            "time::OffsetDateTime::now_utc",
            "time::OffsetDateTime::now_local",
            "quanta::Instant::now",
            "libc::clock_gettime",
            "libc::gettimeofday",
            "libc::time",
        ],
    ),
    (
        WaitKind::Io,
        &[
            "std::net::TcpStream::connect",
            "std::net::TcpListener::bind",
            "std::net::UdpSocket::bind",
            "libc::read",
            "libc::write",
            "libc::open",
            "libc::recv",
            "libc::send",
            "libc::poll",
            "libc::select",
            "libc::ioctl",
            "libc::fsync",
        ],
    ),
];

/// Methods by the path of their type or trait.
const METHODS: &[(WaitKind, &[&str], &[&str])] = &[
    (
        WaitKind::Clock,
        &["std::time::Instant", "std::time::SystemTime", "tokio::time::Instant", "embassy_time::Instant"],
        &["elapsed"],
    ),
    (
        WaitKind::Lock,
        &[
            "std::sync::Mutex",
            "tokio::sync::Mutex",
            "parking_lot::Mutex",
            "parking_lot::FairMutex",
            "parking_lot::ReentrantMutex",
            "spin::Mutex",
            "spin::mutex::Mutex",
            "embassy_sync::mutex::Mutex",
            "async_std::sync::Mutex",
            "futures::lock::Mutex",
        ],
        &["lock", "blocking_lock"],
    ),
    (
        WaitKind::Lock,
        &["std::sync::RwLock", "tokio::sync::RwLock", "parking_lot::RwLock", "spin::RwLock", "async_std::sync::RwLock"],
        &["read", "write", "upgradable_read"],
    ),
    (
        WaitKind::Sleep,
        &[
            "embedded_hal::delay::DelayNs",
            "embedded_hal_async::delay::DelayNs",
            "embedded_hal::blocking::delay::DelayMs",
            "embedded_hal::blocking::delay::DelayUs",
            "embassy_time::Delay",
            "cortex_m::delay::Delay",
        ],
        &["delay_ms", "delay_us", "delay_ns"],
    ),
    (WaitKind::Sleep, &["std::sync::Condvar"], &["wait", "wait_while", "wait_timeout", "wait_timeout_while"]),
    (
        WaitKind::Io,
        &[
            "std::fs::File",
            "std::net::TcpStream",
            "std::net::TcpListener",
            "std::net::UdpSocket",
            "std::os::unix::net::UnixStream",
            "std::os::unix::net::UnixDatagram",
            "std::io::Stdin",
            "std::io::StdinLock",
            "std::process::Command",
            "serialport::SerialPort",
        ],
        &[
            "accept",
            "flush",
            "output",
            "read",
            "read_exact",
            "read_line",
            "read_to_end",
            "read_to_string",
            "recv",
            "recv_from",
            "send",
            "send_to",
            "spawn",
            "status",
            "sync_all",
            "write",
            "write_all",
        ],
    ),
];

/// What a function outside the analysed code has to do with time.
pub(super) fn function_wait(path: &str) -> Option<WaitKind> {
    if path.starts_with("std::fs::") {
        return Some(WaitKind::Io);
    }
    FUNCTIONS.iter().find(|(_, paths)| paths.contains(&path)).map(|(kind, _)| *kind)
}

/// What a method of a type or trait outside the analysed code has to do with time.
pub(super) fn method_wait(owner: &str, method: &str) -> Option<WaitKind> {
    METHODS
        .iter()
        .find(|(_, owners, methods)| owners.contains(&owner) && methods.contains(&method))
        .map(|(kind, ..)| *kind)
}
