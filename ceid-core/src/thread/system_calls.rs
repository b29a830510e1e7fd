//! The system calls of real-time threads on Linux, each behind a safe function.

use core::mem;
use core::ptr;
use std::io;

const NS_PER_S: u64 = 1_000_000_000;

/// The monotonic clock, which the sleeps below use.
#[inline]
pub(super) fn monotonic_ns() -> u64 {
    let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: writes `now`, and nothing else. With this clock and a valid pointer it cannot fail.
    unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &raw mut now) };
    now.tv_sec as u64 * NS_PER_S + now.tv_nsec as u64
}

/// Sleeps until the monotonic clock shows `deadline_ns`, or a signal arrives.
#[inline]
pub(super) fn sleep_until(deadline_ns: u64) {
    let deadline = libc::timespec { tv_sec: (deadline_ns / NS_PER_S) as _, tv_nsec: (deadline_ns % NS_PER_S) as _ };
    // SAFETY: reads `deadline`; an absolute sleep writes no remainder, so that pointer may be null.
    unsafe { libc::clock_nanosleep(libc::CLOCK_MONOTONIC, libc::TIMER_ABSTIME, &raw const deadline, ptr::null_mut()) };
}

/// Keeps every page of the process, present and future, in memory.
pub(super) fn lock_memory() -> io::Result<()> {
    // SAFETY: takes flags only, and changes no memory that the program can see.
    done(unsafe { libc::mlockall(libc::MCL_CURRENT | libc::MCL_FUTURE) })
}

/// Gives this thread a real-time priority that only higher ones preempt.
pub(super) fn schedule_fifo(priority: i32) -> io::Result<()> {
    // SAFETY: all bytes zero is a valid value of this plain C struct.
    let mut parameters: libc::sched_param = unsafe { mem::zeroed() };
    parameters.sched_priority = priority;
    // SAFETY: reads `parameters`, for the thread that calls.
    let error = unsafe { libc::pthread_setschedparam(libc::pthread_self(), libc::SCHED_FIFO, &raw const parameters) };
    // Unlike the others, this function returns its error.
    if error != 0 {
        return Err(io::Error::from_raw_os_error(error));
    }
    as_asked(scheduling()? == (libc::SCHED_FIFO, priority))
}

/// The layout of the kernel's `struct sched_attr`, first version.
#[repr(C)]
struct SchedulingAttributes {
    size: u32,
    policy: u32,
    flags: u64,
    nice: i32,
    priority: u32,
    runtime_ns: u64,
    deadline_ns: u64,
    period_ns: u64,
}

/// Gives this thread `runtime_ns` of processor time in each period.
pub(super) fn schedule_deadline(runtime_ns: u64, period_ns: u64) -> io::Result<()> {
    let attributes = SchedulingAttributes {
        size: size_of::<SchedulingAttributes>() as u32,
        policy: libc::SCHED_DEADLINE as u32,
        flags: 0,
        nice: 0,
        priority: 0,
        runtime_ns,
        deadline_ns: period_ns,
        period_ns,
    };
    // SAFETY: reads `attributes`, whose size it is told, for the thread that calls (0).
    done(unsafe { libc::syscall(libc::SYS_sched_setattr, 0, &raw const attributes, 0) } as i32)?;
    // SAFETY: takes an id only.
    as_asked(unsafe { libc::syscall(libc::SYS_sched_getscheduler, 0) } as i32 == libc::SCHED_DEADLINE)
}

/// The policy and priority of this thread.
pub(super) fn scheduling() -> io::Result<(i32, i32)> {
    // SAFETY: as in `schedule_fifo`.
    let mut parameters: libc::sched_param = unsafe { mem::zeroed() };
    let mut policy = 0;
    // SAFETY: writes both, for the thread that calls.
    let error = unsafe { libc::pthread_getschedparam(libc::pthread_self(), &raw mut policy, &raw mut parameters) };
    if error == 0 { Ok((policy, parameters.sched_priority)) } else { Err(io::Error::from_raw_os_error(error)) }
}

/// Keeps this thread on one processor.
pub(super) fn stay_on(processor: usize) -> io::Result<()> {
    if processor >= libc::CPU_SETSIZE as usize {
        return Err(io::ErrorKind::InvalidInput.into());
    }
    // SAFETY: all bytes zero is the empty set.
    let (mut wanted, mut found): (libc::cpu_set_t, libc::cpu_set_t) = unsafe { mem::zeroed() };
    // SAFETY: the index is in range, checked above.
    unsafe { libc::CPU_SET(processor, &mut wanted) };
    // SAFETY: reads `wanted`, whose size it is told, for the thread that calls (0).
    done(unsafe { libc::sched_setaffinity(0, size_of_val(&wanted), &raw const wanted) })?;
    // SAFETY: writes `found`, whose size it is told.
    done(unsafe { libc::sched_getaffinity(0, size_of_val(&found), &raw mut found) })?;
    // SAFETY: reads both.
    as_asked(unsafe { libc::CPU_EQUAL(&wanted, &found) })
}

fn done(result: i32) -> io::Result<()> {
    if result == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}

/// A call may succeed and not do what it was asked for, in a sandbox or an emulator.
fn as_asked(is: bool) -> io::Result<()> {
    if is { Ok(()) } else { Err(io::ErrorKind::Unsupported.into()) }
}
