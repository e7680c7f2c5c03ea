//! Memory of the whole process.

use std::fs;

use serde::Serialize;

/// What the system says about the memory of the process: both worlds, the driver, and with a software driver the GPU's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(super) struct ProcessMemory {
    /// Bytes in memory now.
    pub(super) resident: u64,
    /// The most so far.
    pub(super) peak: u64,
}

impl ProcessMemory {
    /// `None` where the system does not say so in `/proc`.
    pub(super) fn now() -> Option<Self> {
        Self::read(&fs::read_to_string("/proc/self/status").ok()?)
    }

    fn read(status: &str) -> Option<Self> {
        let bytes = |name: &str| -> Option<u64> {
            let line = status.lines().find_map(|line| line.strip_prefix(name))?;
            let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
            Some(kibibytes * 1024)
        };
        Some(Self {
            resident: bytes("VmRSS:")?,
            peak: bytes("VmHWM:")?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kibibytes_are_read() {
        let status = "Name:\tumbrage\nVmHWM:\t  2048 kB\nVmRSS:\t   300 kB\n";
        let memory = ProcessMemory {
            resident: 307_200,
            peak: 2_097_152,
        };
        assert_eq!(ProcessMemory::read(status), Some(memory));
        assert_eq!(ProcessMemory::read("Name:\tumbrage\n"), None);
    }
}
