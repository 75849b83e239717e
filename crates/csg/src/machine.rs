//! What the machine has.

use std::sync::OnceLock;

/// The bytes of memory of this machine, or of what the process may use of it (on Linux, by
/// its control group); none where that is not known.
pub(crate) fn memory() -> Option<u64> {
    static BYTES: OnceLock<Option<u64>> = OnceLock::new();
    *BYTES.get_or_init(|| [of_machine(), of_group()].into_iter().flatten().min())
}

/// `MemTotal` of proc(5), in kibibytes there.
fn of_machine() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// `memory.max` of the kernel's second version of control groups; "max" is no limit.
fn of_group() -> Option<u64> {
    let text = std::fs::read_to_string("/sys/fs/cgroup/memory.max").ok()?;
    text.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    #[test]
    #[cfg(target_os = "linux")]
    fn a_machine_has_some_memory() {
        let bytes = super::memory().expect("known on Linux");
        assert!((1 << 26..1 << 50).contains(&bytes), "{bytes}");
    }
}
