use rand::Rng;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Random numbers keyed by what they are for: one ChaCha8 key per (seed, design), one stream per (run, channel), which
/// seeds the fast generator that the channel draws from. What a run draws depends on nothing else.
#[derive(Clone, Debug)]
pub struct Streams {
    key: [u8; 32],
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
        let mut keyed = ChaCha8Rng::from_seed(self.key);
        keyed.set_stream(u64::from(run) << 32 | u64::from(channel));
        Xoshiro256PlusPlus::from_rng(&mut keyed)
    }

    /// Fills `out` with standard normal numbers from one channel of one run.
    pub fn normals(&self, run: u32, channel: u32, out: &mut [f64]) {
        let mut rng = self.channel(run, channel);
        for value in out {
            *value = StandardNormal.sample(&mut rng);
        }
    }

    /// `count` whole numbers below `below`, equally likely.
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

/// The 64-bit FNV-1a hash: turns a name into key bits.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}
