//! What time it is, for reports and limits of time.

#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
pub(crate) use std::time::Instant;

#[cfg(all(target_family = "wasm", target_os = "unknown"))]
pub(crate) use self::stopped::Instant;

/// WebAssembly without a system has no clock: stages take no time there, and limits of time
/// are not reached.
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
mod stopped {
    use std::ops::Sub;
    use std::time::Duration;

    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub(crate) struct Instant(Duration);

    impl Instant {
        pub(crate) fn now() -> Self {
            Self(Duration::ZERO)
        }

        pub(crate) fn checked_add(&self, duration: Duration) -> Option<Self> {
            // A limit of no time at all is reached at once, as everywhere.
            self.0.checked_add(duration).map(Self)
        }
    }

    impl Sub for Instant {
        type Output = Duration;

        fn sub(self, earlier: Self) -> Duration {
            self.0.saturating_sub(earlier.0)
        }
    }
}
