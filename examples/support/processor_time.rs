//! Processor time, which a busy machine does not falsify as it does the clock's.

use std::error::Error;

/// User and system time of this process so far.
pub(crate) fn processor_seconds() -> Result<f64, Box<dyn Error>> {
    /// Linux reports times in hundredths of a second whatever the kernel's own clock.
    const TICKS_PER_SECOND: f64 = 100.0;
    let text = std::fs::read_to_string("/proc/self/stat")?;
    let after_name = text.rsplit_once(')').ok_or("the process's own statistics have no name")?.1;
    let fields: Vec<&str> = after_name.split_whitespace().collect();
    let [user, system] = [11, 12].map(|index| fields.get(index).and_then(|field| field.parse::<f64>().ok()));
    Ok((user.unwrap_or(0.0) + system.unwrap_or(0.0)) / TICKS_PER_SECOND)
}
