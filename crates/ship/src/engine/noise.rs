use numerics::LANES;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::engine::normals::{Normals, fill_normals};

/// Random numbers keyed by their purpose: one ChaCha8 key per (seed, design), one stream per run, of which 32
/// bytes per channel seed the fast generator that the channel draws from. A run's draws depend on nothing
/// else.
#[derive(Clone, Debug)]
pub struct Streams {
    key: [u8; 32],
}

/// Rows of independent standard normal numbers of one run, drawn a block of samples at a time: block k is channel k.
#[derive(Clone, Debug)]
pub struct NormalRows<const WIDTH: usize> {
    streams: Streams,
    run: u32,
    /// Rows so far.
    taken: usize,
    block: Vec<f64>,
}

/// Rows that are drawn at a time.
const BLOCK: usize = 128;

impl<const WIDTH: usize> NormalRows<WIDTH> {
    /// Those of run `run` of `streams`.
    pub fn new(streams: Streams, run: u32) -> Self {
        Self { streams, run, taken: 0, block: Vec::new() }
    }
}

impl<const WIDTH: usize> Iterator for NormalRows<WIDTH> {
    type Item = [f64; WIDTH];

    fn next(&mut self) -> Option<[f64; WIDTH]> {
        let place = self.taken % BLOCK;
        if place == 0 {
            self.block.resize(WIDTH * BLOCK, 0.0);
            self.streams.normals(self.run, (self.taken / BLOCK) as u32, &mut self.block);
        }
        self.taken += 1;
        Some(std::array::from_fn(|i| self.block[WIDTH * place + i]))
    }
}

impl Streams {
    /// The streams of `purpose` (the name of a design, a generator) in a study with seed `seed`.
    pub fn new(seed: u64, purpose: &str) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&fnv1a(purpose.as_bytes()).to_le_bytes());
        Self { key }
    }

    /// The generator of one channel of one run.
    pub fn channel(&self, run: u32, channel: u32) -> Xoshiro256PlusPlus {
        Xoshiro256PlusPlus::from_rng(&mut self.keyed(run, channel))
    }

    /// Fills `out` with standard normal numbers from one channel of one run.
    pub fn normals(&self, run: u32, channel: u32, out: &mut [f64]) {
        fill_normals(self.channel(run, channel), out);
    }

    /// The channels of [`LANES`] runs from `first` on.
    pub(crate) fn lanes(&self, runs: [u32; LANES], first: u32) -> Channels {
        let mut seeds = [[[0; 32]; AHEAD]; LANES];
        for (seeds, run) in seeds.iter_mut().zip(runs) {
            self.keyed(run, first).fill_bytes(seeds.as_flattened_mut());
        }
        Channels { seeds, next: 0 }
    }

    /// The seeds of a run's generators from `channel` on, 32 bytes each.
    fn keyed(&self, run: u32, channel: u32) -> ChaCha8Rng {
        let mut keyed = ChaCha8Rng::from_seed(self.key);
        keyed.set_stream(u64::from(run));
        keyed.set_word_pos(8 * u128::from(channel));
        keyed
    }

    /// `count` integers below `below`, uniformly distributed.
    pub fn choices(&self, run: u32, channel: u32, below: u32, count: usize) -> Vec<u32> {
        let mut rng = self.channel(run, channel);
        let limit = (1u64 << 32) / u64::from(below) * u64::from(below);
        let mut draw = || loop {
            let bits = u64::from(rng.next_u32());
            if bits < limit {
                return (bits % u64::from(below)) as u32;
            }
        };
        (0..count).map(|_| draw()).collect()
    }
}

/// Most channels that are taken in sequence.
const AHEAD: usize = 8;

/// Channels of a lane of runs, taken in sequence: the seeds of their generators.
pub(crate) struct Channels {
    seeds: [[[u8; 32]; AHEAD]; LANES],
    next: usize,
}

impl Channels {
    /// The normal numbers of the next channels.
    pub(crate) fn next<const CHANNELS: usize>(&mut self) -> [Normals; CHANNELS] {
        let first = self.next;
        self.next += CHANNELS;
        std::array::from_fn(|i| Normals::seeded(self.seeds.each_ref().map(|own| &own[first + i])))
    }
}

/// The 64-bit FNV-1a hash: converts a name to key bits.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}
