//! Things joined to groups.

/// Galler and Fischer's disjoint sets: numbers joined to groups, each named by the least of it.
#[derive(Default)]
pub(crate) struct Groups(Vec<u32>);

impl Groups {
    /// Each for itself.
    pub fn new(count: usize) -> Self {
        let mut groups = Self::default();
        groups.reset(count);
        groups
    }

    /// Each for itself again.
    pub fn reset(&mut self, count: usize) {
        self.0.clear();
        // (What has no number belongs to no group.)
        self.0.extend((0..=u32::MAX).take(count));
    }

    /// The least of a number's group, halving the way there.
    #[inline]
    pub fn first(&mut self, mut of: u32) -> u32 {
        while self.0[of as usize] != of {
            let above = self.0[self.0[of as usize] as usize];
            self.0[of as usize] = above;
            of = above;
        }
        of
    }

    /// Whether they were in different groups.
    #[inline]
    pub fn join(&mut self, pair: [u32; 2]) -> bool {
        let [a, b] = pair.map(|of| self.first(of));
        self.0[a.max(b) as usize] = a.min(b);
        a != b
    }
}
