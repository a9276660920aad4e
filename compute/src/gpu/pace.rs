//! How much goes into a submission.

use std::time::{Duration, Instant};

use super::atlas::TILES_PER_HEMICUBE;

/// How many tiles go into a submission.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    tiles: u32,
    most: u32,
    /// When the last submission ended.
    last_end: Option<Instant>,
}

impl Pace {
    /// How long a submission should take. Watchdogs bite after 2 s and up; a desktop that shares
    /// the GPU stutters after a fraction of that; a tenth of a second makes any overhead small.
    const TARGET: Duration = Duration::from_millis(100);
    /// Hemicubes in the first submission, with nothing known about the adapter.
    const FIRST_HEMICUBES: u32 = 8;
    /// The most that one measurement makes submissions grow.
    const MAX_GROWTH: f64 = 4.0;

    /// Little at first, at most so many tiles.
    pub fn new(most: u32) -> Self {
        let first = Self::FIRST_HEMICUBES * TILES_PER_HEMICUBE as u32;
        Self {
            tiles: first.min(most),
            most,
            last_end: None,
        }
    }

    /// How many tiles go into the next submission.
    pub fn tiles(&self) -> u32 {
        self.tiles
    }

    /// Takes into account that a submission of that many tiles, made then, was just seen to have ended. The
    /// device began it when it had ended the one before; that it was seen to end late makes it
    /// seem longer, never shorter.
    pub fn ended(&mut self, tiles: u32, submitted: Instant) {
        let now = Instant::now();
        let start = self.last_end.map_or(submitted, |end| end.max(submitted));
        self.last_end = Some(now);
        self.learn(tiles, now.duration_since(start));
    }

    /// The same, of a submission that took that long.
    fn learn(&mut self, tiles: u32, duration: Duration) {
        let per_tile = duration.as_secs_f64() / f64::from(tiles.max(1));
        // A small submission says little of a large one.
        let most = (f64::from(tiles) * Self::MAX_GROWTH).max(self.tiles.into());
        let mut wanted = (Self::TARGET.as_secs_f64() / per_tile).min(most);
        if duration <= Self::TARGET {
            // A batch's last submission is a small one, and is mostly overhead.
            wanted = wanted.max(self.tiles.into());
        }
        self.tiles = (wanted as u32).clamp(1, self.most);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn submissions_grow_towards_the_target_and_shrink_at_once() {
        let mut pace = Pace::new(1000);
        let per_tile = Pace::TARGET / 500;
        for _ in 0..5 {
            let before = pace.tiles;
            pace.learn(before, per_tile * before);
            assert!(f64::from(pace.tiles) <= f64::from(before) * Pace::MAX_GROWTH);
        }
        assert!((499..=500).contains(&pace.tiles), "{}", pace.tiles);
        // A last, small submission teaches nothing new.
        pace.learn(3, per_tile * 30);
        assert!((499..=500).contains(&pace.tiles), "{}", pace.tiles);
        pace.learn(500, Pace::TARGET * 100);
        assert_eq!(pace.tiles, 5);
        pace.learn(5, Pace::TARGET * 1000);
        assert_eq!(pace.tiles, 1);
        pace.learn(1, Duration::ZERO);
        assert_eq!(pace.tiles, 4);
        Pace::new(2).learn(2, Duration::ZERO);
    }
}
