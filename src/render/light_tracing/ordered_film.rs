//! Film that receives the splats of waves, which end in any order, in the order of the waves.
//!
//! The film is divided into strips of rows. The splats of a wave are sorted by strip. Once some waves
//! have ended, a worker adds them to one strip after another, while the other workers trace further
//! waves. A second worker that adds waves follows the first from strip to strip.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::film::{FilmStrip, FilmSums, Frame, Response, Splat};

/// Workers add waves to the film once this many have ended.
const WAVES_AT_ONCE: u64 = 8;
/// Fewest pixels of a strip.
const STRIP_PIXELS: u32 = 1 << 11;
/// Most strips.
const STRIPS: u32 = 256;

/// Film that receives the light of waves in their order.
pub(super) struct OrderedFilm<'a> {
    response: &'a Response,
    /// First row of the film.
    top: u32,
    /// Base-2 logarithm of the number of rows of a strip; the last may have fewer.
    log_rows: u32,
    strips: Vec<Mutex<Strip<'a>>>,
    waves: Mutex<Waves>,
    /// Number of waiting splats from which on there is no room for those of another wave.
    most_waiting: usize,
}

/// A strip of the film, and the number of the next wave that it receives.
struct Strip<'a> {
    film: FilmStrip<'a>,
    next: u64,
}

/// Waves that have ended and are not yet in all strips.
#[derive(Default)]
struct Waves {
    /// Waves by number, before each of which a wave is still missing.
    early: BTreeMap<u64, Arc<SortedSplats>>,
    /// Successive waves.
    ended: Vec<Arc<SortedSplats>>,
    /// Number of the first wave of `ended`.
    first: u64,
    /// Number of the first wave that no worker adds yet.
    claimed: u64,
    /// Size of all waves, in splats.
    waiting: usize,
}

/// Splats of a wave, strip by strip.
struct SortedSplats {
    splats: Vec<Splat>,
    /// End of each strip in them.
    ends: Vec<u32>,
}

impl<'a> OrderedFilm<'a> {
    /// Prepares a film of this frame. It has room for a wave until `most_waiting` splats wait.
    pub fn new(
        film: &'a mut FilmSums,
        frame: &Frame,
        response: &'a Response,
        most_waiting: usize,
    ) -> Self {
        let [width, height] = frame.size();
        let rows = STRIP_PIXELS.div_ceil(width.max(1)).max(height.div_ceil(STRIPS));
        let log_rows = rows.next_power_of_two().trailing_zeros();
        let strip = |film| Mutex::new(Strip { film, next: 0 });
        let strips = film.strips(1 << log_rows).into_iter().map(strip).collect();
        Self {
            response,
            top: frame.low[1],
            log_rows,
            strips,
            waves: Mutex::default(),
            most_waiting,
        }
    }

    /// Returns whether the splats that wait leave room for those of another wave.
    pub fn has_room(&self) -> bool {
        lock(&self.waves).waiting < self.most_waiting
    }

    /// Takes the splats of a wave, and adds those that it completes.
    pub fn add(&self, wave: u64, splats: Vec<Splat>) {
        let sorted = Arc::new(self.sort(splats));
        let mut waves = lock(&self.waves);
        waves.waiting += sorted.size();
        waves.early.insert(wave, sorted);
        waves.find_ended();
        let unclaimed = waves.end() - waves.claimed;
        // Large waves are added sooner, since the room is shared.
        let is_crowded = unclaimed > 0 && waves.waiting > self.most_waiting / 2;
        if unclaimed >= WAVES_AT_ONCE || is_crowded {
            self.add_ended(waves);
        }
    }

    /// Adds all waves that have ended. Returns the number of the first wave that is missing.
    pub fn finish(&self) -> u64 {
        let waves = lock(&self.waves);
        let end = waves.end();
        self.add_ended(waves);
        end
    }

    /// Adds all waves that have ended to all strips.
    fn add_ended(&self, mut waves: MutexGuard<'_, Waves>) {
        // Another worker may be adding some of them: each strip takes a wave from whoever comes first.
        let (ended, first, end) = (waves.ended.clone(), waves.first, waves.end());
        waves.claimed = end;
        drop(waves);
        for (i, strip) in self.strips.iter().enumerate() {
            let Strip { film, next } = &mut *lock(strip);
            for wave in *next..end {
                for splat in ended[(wave - first) as usize].of_strip(i) {
                    film.add(splat, self.response);
                }
            }
            *next = end.max(*next);
        }
        lock(&self.waves).forget(end);
    }

    /// Sorts the splats of a wave by strip. Those of a strip keep their order.
    fn sort(&self, splats: Vec<Splat>) -> SortedSplats {
        let strip = |splat: &Splat| ((splat.pixel[1] - self.top) >> self.log_rows) as usize;
        let mut ends = vec![0; self.strips.len()];
        for splat in &splats {
            ends[strip(splat)] += 1;
        }
        let mut sum = 0;
        for end in &mut ends {
            (*end, sum) = (sum, sum + *end);
        }
        // The start of each strip becomes its end.
        let mut sorted = splats.clone();
        for splat in splats {
            let at = &mut ends[strip(&splat)];
            sorted[*at as usize] = splat;
            *at += 1;
        }
        SortedSplats { splats: sorted, ends }
    }
}

impl Waves {
    /// Returns the number of the first wave that is missing.
    fn end(&self) -> u64 {
        self.first + self.ended.len() as u64
    }

    /// Moves early waves that follow the last to the end.
    fn find_ended(&mut self) {
        while let Some(wave) = self.early.remove(&self.end()) {
            self.ended.push(wave);
        }
    }

    /// Forgets the waves before this number, which are in all strips.
    fn forget(&mut self, end: u64) {
        let count = end.saturating_sub(self.first);
        let forgotten = self.ended.drain(..count as usize);
        self.waiting -= forgotten.map(|wave| wave.size()).sum::<usize>();
        self.first += count;
    }
}

impl SortedSplats {
    /// Returns the size of the wave, in splats.
    fn size(&self) -> usize {
        self.splats.len() + self.ends.len() * size_of::<u32>() / size_of::<Splat>()
    }

    /// Returns the splats of a strip.
    fn of_strip(&self, strip: usize) -> &[Splat] {
        let start = strip.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.splats[start as usize..self.ends[strip] as usize]
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;
    use crate::film::{ExtraChannels, Tile};
    use petzval_base::sampler::hash;
    use petzval_spectrum::{BucketShares, Buckets};

    const FRAME: Frame = Frame { resolution: [900, 70], low: [30, 5], high: [700, 61] };

    /// Splats of a wave, all over the frame.
    fn splats(wave: u64) -> Vec<Splat> {
        let random = |i: u32| hash(i ^ hash(wave as u32));
        let splat = |i: u32| {
            let [x, y] = [0, 1].map(|axis| {
                let size = FRAME.size()[axis];
                FRAME.low[axis] + random(4 * i + axis as u32) % size
            });
            // Sums of numbers that differ so much depend on their order.
            let light = [2, 3, 7].map(|c| random(c * i) as f32 * 1e-3f32.powi((i % 6) as i32));
            Splat { pixel: [x, y], set: (i % 64) as u16, left_half: i.is_multiple_of(3), light }
        };
        (0..random(1) % 9000).map(splat).collect()
    }

    /// Film of two buckets of wavelength that records the light of the left half of the pupil.
    fn film() -> FilmSums {
        let buckets = Buckets::new(2, [400.0, 700.0]).expect("buckets");
        let buckets = Some(Arc::new(BucketShares::new(buckets)));
        FilmSums::new(FRAME).with_extra(&ExtraChannels { buckets, left_half: true })
    }

    /// Adds the splats of waves to a film in the order of the waves.
    fn add_in_order(waves: u64, film: &mut FilmSums, response: &Response) {
        for strip in &mut film.strips(FRAME.size()[1]) {
            for splat in (0..waves).flat_map(splats) {
                strip.add(&splat, response);
            }
        }
    }

    fn assert_same(found: &FilmSums, expected: &FilmSums) {
        assert_eq!(found.picture(1).pixels, expected.picture(1).pixels);
        let whole = Tile { low: FRAME.low, size: FRAME.size() };
        assert_eq!(found.tile(&whole).extra_sums(), expected.tile(&whole).extra_sums());
    }

    #[test]
    fn each_pixel_receives_the_splats_in_the_order_of_the_waves() {
        let (waves, response) = (100, Response::default());
        let mut expected = film();
        add_in_order(waves, &mut expected, &response);
        // With little room, waves are added one by one.
        for (threads, room) in [(1, usize::MAX), (2, usize::MAX), (7, usize::MAX), (3, 1)] {
            let mut found = film();
            let film = OrderedFilm::new(&mut found, &FRAME, &response, room);
            assert!(film.strips.len() > 3, "{} strips", film.strips.len());
            let next = AtomicU64::new(0);
            std::thread::scope(|scope| {
                let work = || {
                    loop {
                        // Neighbours change places, and so do the waves of two threads.
                        let i = next.fetch_add(1, Ordering::Relaxed);
                        if i >= waves {
                            return;
                        }
                        film.add(i ^ 1, splats(i ^ 1));
                    }
                };
                for _ in 0..threads {
                    scope.spawn(work);
                }
            });
            assert_eq!(film.finish(), waves);
            assert!(film.has_room() && lock(&film.waves).waiting == 0);
            drop(film);
            assert_same(&found, &expected);
        }
    }

    #[test]
    fn workers_that_add_the_same_waves_add_them_once() {
        let (waves, response) = (6, Response::default());
        let [mut expected, mut found] = [film(), film()];
        add_in_order(waves, &mut expected, &response);
        let film = OrderedFilm::new(&mut found, &FRAME, &response, usize::MAX);
        (0..waves).for_each(|wave| film.add(wave, splats(wave)));
        std::thread::scope(|scope| {
            let strip = lock(&film.strips[1]);
            let both = [(); 2].map(|()| scope.spawn(|| film.finish()));
            // Both have copied the list of waves by then, or come later and find it empty.
            std::thread::sleep(std::time::Duration::from_millis(50));
            drop(strip);
            for worker in both {
                assert_eq!(worker.join().expect("a worker"), waves);
            }
        });
        drop(film);
        assert_same(&found, &expected);
    }

    #[test]
    fn splats_after_a_missing_wave_wait() {
        let (mut film, response) = (film(), Response::default());
        let ordered = OrderedFilm::new(&mut film, &FRAME, &response, 50_000);
        (1..40).for_each(|wave| ordered.add(wave, splats(wave)));
        assert_eq!(ordered.finish(), 0);
        assert!(!ordered.has_room());
        ordered.add(0, splats(0));
        assert_eq!(ordered.finish(), 40);
        assert!(ordered.has_room() && lock(&ordered.waves).waiting == 0);
    }
}
