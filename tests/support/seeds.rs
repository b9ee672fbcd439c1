//! Schedules of faults, each from its seed: one that is told, or many on all processors.

use std::collections::BTreeMap;

/// How often which fault was met.
pub(crate) type Faults = BTreeMap<&'static str, u64>;

/// What many schedules met.
pub(crate) struct Schedules {
    /// How many there were.
    pub(crate) seeds: u64,
    pub(crate) faults: Faults,
}

/// Runs the schedule of the seed that the environment's `variable` names, told, and answers nothing; else as many as `variable` with an S
/// says, `usual` by default.
pub(crate) fn run_seeds(variable: &str, usual: u64, run: impl Fn(u64, bool) -> Faults + Sync) -> Option<Schedules> {
    let number = |name: &str| std::env::var(name).ok().map(|number| number.parse::<u64>().expect("a number"));
    if let Some(seed) = number(variable) {
        run(seed, true);
        return None;
    }
    let seeds = number(&format!("{variable}S")).unwrap_or(usual);
    let threads = std::thread::available_parallelism().map_or(1, |count| count.get() as u64);
    let run = &run;
    let share = |first: u64| {
        move || {
            let mut faults = Faults::new();
            (first..seeds).step_by(threads as usize).for_each(|seed| add(&mut faults, run(seed, false)));
            faults
        }
    };
    let mut faults = Faults::new();
    std::thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|first| scope.spawn(share(first))).collect();
        running.into_iter().for_each(|thread| add(&mut faults, thread.join().expect("every schedule holds")));
    });
    println!("{seeds} schedules, faults: {faults:?}");
    Some(Schedules { seeds, faults })
}

fn add(sum: &mut Faults, found: Faults) {
    for (fault, count) in found {
        *sum.entry(fault).or_default() += count;
    }
}
