//! Best of several passes.

use std::time::{Duration, Instant};

use cpu_time::ProcessTime;

/// How often something is measured.
#[derive(Clone, Copy)]
pub struct Passes {
    /// At least so many passes,
    pub least: u32,
    /// and more until so much time is spent,
    pub fill: Duration,
    /// but no further pass once so much time is spent, whatever `least` says.
    pub most: Duration,
}

impl Passes {
    /// At least three passes, more within `fill` seconds, one only if it took
    /// longer than `most` seconds.
    pub fn within(fill: f64, most: f64) -> Self {
        Self {
            least: 3,
            fill: Duration::from_secs_f64(fill),
            most: Duration::from_secs_f64(most),
        }
    }

    /// The least times of a pass, and what the last pass returned.
    pub fn best<T>(self, mut pass: impl FnMut() -> T) -> (Times, T) {
        let begun = Instant::now();
        let mut best = Times {
            wall: f64::INFINITY,
            cpu: f64::INFINITY,
        };
        let mut passes = 0;
        loop {
            let (cpu, wall) = (ProcessTime::now(), Instant::now());
            let result = pass();
            best.wall = best.wall.min(wall.elapsed().as_secs_f64());
            best.cpu = best.cpu.min(cpu.elapsed().as_secs_f64());
            passes += 1;
            let spent = begun.elapsed();
            if spent >= self.most || (passes >= self.least && spent >= self.fill) {
                return (best, result);
            }
        }
    }
}

/// Seconds on the clock, and of all threads of the process together. The
/// latter stand up better to a machine that is busy with other things.
#[derive(Clone, Copy)]
pub struct Times {
    /// On the clock.
    pub wall: f64,
    /// Of all threads.
    pub cpu: f64,
}

/// Runs `work` on a rayon pool of so many threads.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("the system starts threads").install(work)
}
