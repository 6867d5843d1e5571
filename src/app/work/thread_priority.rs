//! What the operating system says of the calling thread, and how threads that work make way for the one that draws.

use std::time::Duration;

/// Processor time that the calling thread has spent so far; `None` where the system does not tell.
#[cfg(target_os = "linux")]
pub(crate) fn cpu_time() -> Option<Duration> {
    let spent = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(Duration::new(spent.tv_sec.try_into().ok()?, spent.tv_nsec.try_into().ok()?))
}

/// Processor time that the calling thread has spent so far; `None` where the system does not tell.
#[cfg(not(target_os = "linux"))]
pub(crate) fn cpu_time() -> Option<Duration> {
    None
}

/// Lets the thread that draws, and those whose pictures are waited for, go before the calling one, which works for minutes.
/// Linux keeps a niceness per thread; other systems put the threads of the window in front first anyway. It is a wish: where it
/// is refused nothing is lost but evenness.
pub(crate) fn make_way() {
    // A third of the share of others: more, and a window in steady motion would starve the work that it waits for.
    #[cfg(target_os = "linux")]
    let _ = rustix::process::setpriority_process(None, 5);
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn a_thread_that_works_makes_way_and_no_other_does() {
        let niceness = || rustix::process::getpriority_process(None).unwrap();
        let own = niceness();
        let worker = std::thread::Builder::new().name("worker".to_owned());
        let theirs = worker.spawn(move || {
            make_way();
            niceness()
        });
        assert_eq!((theirs.unwrap().join().unwrap(), niceness()), (5, own));
    }

    #[test]
    fn time_asleep_is_not_time_spent() {
        let before = cpu_time().unwrap();
        std::thread::sleep(Duration::from_millis(40));
        assert!(cpu_time().unwrap() < before + Duration::from_millis(20));
    }
}
