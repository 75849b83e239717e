//! A part of work that others do the rest of.

use std::ops::Range;
use std::str::FromStr;

/// Which part, from 1, of how many.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shard {
    pub(crate) part: usize,
    pub(crate) of: usize,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text
            .split_once('/')
            .and_then(|(part, of)| Some((part.trim().parse().ok()?, of.trim().parse().ok()?)));
        match numbers {
            Some((part, of)) if (1..=of).contains(&part) => Ok(Self { part, of }),
            _ => Err("give a part and how many there are, like 1/4 to 4/4".into()),
        }
    }
}

impl Shard {
    /// Its rows of so many.
    pub(crate) fn rows(self, count: usize) -> Range<usize> {
        // (Counts that overflow do not fit into memory.)
        let start = |part: usize| (part as u128 * count as u128 / self.of as u128) as usize;
        start(self.part - 1)..start(self.part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_the_whole() {
        for count in [0, 1, 7, 100] {
            for of in [1, 2, 3, 8, 200] {
                let parts = (1..=of).flat_map(|part| Shard { part, of }.rows(count));
                assert!(parts.eq(0..count), "{count} in {of}");
            }
        }
        assert_eq!("2/3".parse(), Ok(Shard { part: 2, of: 3 }));
        for faulty in ["", "1", "0/3", "4/3", "1/0", "-1/3", "a/b"] {
            assert!(faulty.parse::<Shard>().is_err(), "{faulty}");
        }
    }
}
