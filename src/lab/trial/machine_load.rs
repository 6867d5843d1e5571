//! How much of the machine other programs use while something is timed. Linux alone says so, in ticks since it was started.

use std::fs;

/// Fewer ticks of all processors, mostly a hundredth of a second each, say nothing.
const LEAST_TICKS: u64 = 20;

/// Ticks of all processors, and of them those that this program and others used.
#[derive(Clone, Copy, Debug)]
struct Ticks {
    all: u64,
    own: u64,
    busy: u64,
}

/// A moment from which the load is measured; `None` where the system does not say it.
#[derive(Clone, Copy, Debug)]
pub(super) struct MachineLoad(Option<Ticks>);

impl MachineLoad {
    /// Now.
    pub(super) fn start() -> Self {
        Self(ticks())
    }

    /// The share of all processors' time that other programs used since then, 0 to 1; `None` where it is not known, or too short a time.
    pub(super) fn of_others(self) -> Option<f64> {
        let (before, now) = self.0.zip(ticks())?;
        let since = |of: fn(Ticks) -> u64| of(now).saturating_sub(of(before));
        let others = since(|ticks| ticks.busy).saturating_sub(since(|ticks| ticks.own));
        let all = since(|ticks| ticks.all);
        (all >= LEAST_TICKS).then(|| others as f64 / all as f64)
    }
}

fn ticks() -> Option<Ticks> {
    parsed(&fs::read_to_string("/proc/stat").ok()?, &fs::read_to_string("/proc/self/stat").ok()?)
}

/// Reads both files, as proc(5) describes them.
fn parsed(machine: &str, own: &str) -> Option<Ticks> {
    let of_all = machine.lines().next()?.strip_prefix("cpu ")?;
    // user, nice, system, idle, iowait, irq, softirq, steal; time of guests is among that of users.
    let of_all: Vec<u64> =
        of_all.split_whitespace().take(8).map(str::parse).collect::<Result<_, _>>().ok()?;
    let (all, idle) = (of_all.iter().sum::<u64>(), of_all.get(3..5)?.iter().sum::<u64>());
    // The name of a program may hold spaces and brackets; utime and stime are the 12th and 13th of what follows it.
    let after_name = own.rsplit_once(')')?.1;
    let of_self: Vec<u64> = after_name.split_whitespace().skip(11).take(2).flat_map(str::parse).collect();
    let [user, system] = of_self[..] else { return None };
    Some(Ticks { all, own: user + system, busy: all - idle })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_others_used_is_what_was_neither_idle_nor_our_own() {
        let machine = "cpu  100 0 50 800 20 0 10 20 5 0\ncpu0 1 2 3 4\n";
        let own = "42 (a (b) c) S 1 42 42 0 -1 4194304 100 0 0 0 60 30 0 0 20 0 3 0 100";
        let before = parsed(machine, own).unwrap();
        assert_eq!((before.all, before.busy, before.own), (1000, 180, 90));
        assert!(parsed("intr 1", own).is_none() && parsed(machine, "42").is_none());
        let load = MachineLoad::start().of_others();
        assert!(load.is_none_or(|share| (0.0..=1.0).contains(&share)), "{load:?}");
    }
}
