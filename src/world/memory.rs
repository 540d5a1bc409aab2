//! How much memory a search holds, and how much there is.

/// The memory of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryPlan {
    /// About how many bytes it holds.
    pub bytes: u64,
    /// Candidates that are simulated at a time.
    pub at_once: u32,
}

/// Bytes of the machine's memory that are free, within the limits of its container; none if that is not known.
pub fn free_memory() -> Option<u64> {
    let mut system = sysinfo::System::new().ok()?;
    system.refresh_memory();
    let free = system.cgroup_limits().map_or(u64::MAX, |limits| limits.free_memory);
    Some(system.available_memory().min(free)).filter(|bytes| *bytes > 0)
}
