use numerics::{LANES, Lane, vectorized};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Random numbers keyed by their purpose: one ChaCha8 key per (seed, design), one stream per run, of which 32 bytes per channel
/// seed the fast generator that the channel draws from. A run's draws depend on nothing else.
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
        std::array::from_fn(|i| Normals::seeded(self.seeds.each_ref().map(|seeds| &seeds[first + i])))
    }
}

/// The 64-bit FNV-1a hash: converts a name to key bits.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Standard normal numbers, two at a time, for a lane of runs: every run draws from a Xoshiro256++ generator
/// of its own, by the method of Box and Muller.
///
/// The functions in it are polynomials with a relative error below 1.2e-10; they use only additions and multiplications, fused
/// exactly where written so, and a square root, so that all instruction sets give the same bits. No number exceeds 8.5.
#[derive(Clone, Debug)]
pub(crate) struct Normals {
    /// Word by word, in the layout of vectors.
    state: [[u64; LANES]; 4],
}

impl Normals {
    /// Seeded by 32 bytes per lane.
    fn seeded(seeds: [&[u8; 32]; LANES]) -> Self {
        let mut state = [[0; LANES]; 4];
        for (lane, seed) in seeds.into_iter().enumerate() {
            for (word, bytes) in state.iter_mut().zip(seed.as_chunks::<8>().0) {
                word[lane] = u64::from_le_bytes(*bytes);
            }
        }
        Self { state }
    }

    /// The next two numbers of every lane.
    #[inline(always)]
    pub(crate) fn pair(&mut self) -> [Lane; 2] {
        let (radius, angle) = (self.bits(), self.bits());
        pairs(&radius, &angle)
    }

    /// A step of Xoshiro256++ (Blackman & Vigna) in every lane.
    #[inline(always)]
    fn bits(&mut self) -> [u64; LANES] {
        let [a, b, c, d] = &mut self.state;
        let mut out = [0; LANES];
        for lane in 0..LANES {
            out[lane] = a[lane].wrapping_add(d[lane]).rotate_left(23).wrapping_add(a[lane]);
            let shifted = b[lane] << 17;
            c[lane] ^= a[lane];
            d[lane] ^= b[lane];
            b[lane] ^= c[lane];
            a[lane] ^= d[lane];
            c[lane] ^= shifted;
            d[lane] = d[lane].rotate_left(45);
        }
        out
    }
}

/// Fills `out` with standard normal numbers from the bits of `generator`, two from each two of its 64-bit numbers, by the
/// method of Box and Muller. [`Streams::normals`](crate::engine::Streams::normals) has those of a channel.
pub fn fill_normals(mut generator: impl Rng, out: &mut [f64]) {
    vectorized!({
        for out in out.chunks_mut(2 * LANES) {
            let (mut radius, mut angle) = ([0; LANES], [0; LANES]);
            for pair in 0..LANES {
                (radius[pair], angle[pair]) = (generator.next_u64(), generator.next_u64());
            }
            let [first, second] = pairs(&radius, &angle);
            for (i, value) in out.iter_mut().enumerate() {
                *value = if i % 2 == 0 { first[i / 2] } else { second[i / 2] };
            }
        }
    });
}

/// Two normal numbers from 128 random bits of every lane.
#[inline(always)]
fn pairs(radius: &[u64; LANES], angle: &[u64; LANES]) -> [Lane; 2] {
    let mut out = [Lane::ZERO; 2];
    let [first, second] = &mut out;
    for lane in 0..LANES {
        (first.0[lane], second.0[lane]) = box_muller(radius[lane], angle[lane]);
    }
    out
}

/// Two normal numbers from 128 random bits: a point whose distance from the origin comes from `radius` and whose
/// direction comes from `angle`.
#[inline(always)]
fn box_muller(radius: u64, angle: u64) -> (f64, f64) {
    // 1 in steps of 2^-52 down to 2^-52.
    let uniform = 2.0 - f64::from_bits(radius >> 12 | ONE);
    let distance = minus_twice_log(uniform).sqrt();
    // An eighth of a turn to either side of an axis, which two more bits select.
    let eighths = f64::from_bits(angle >> 12 | TWO) - 3.0;
    let sign = (angle << 52) & SIGN;
    let square = eighths * eighths;
    let along = f64::from_bits((distance * cosine(square)).to_bits() ^ sign);
    let across = distance * (eighths * sine(square));
    if angle & 1 << 10 == 0 { (along, across) } else { (across, along) }
}

const ONE: u64 = 1.0_f64.to_bits();
const TWO: u64 = 2.0_f64.to_bits();
const SIGN: u64 = 1 << 63;
/// √½: smaller numbers are doubled first.
const LOWEST: u64 = std::f64::consts::FRAC_1_SQRT_2.to_bits();

/// −2 ln x for 0 < x ≤ 1: the exponent's part and a polynomial in y − 1 for y = x 2^−exponent, √½ ≤ y < √2.
#[inline(always)]
fn minus_twice_log(x: f64) -> f64 {
    const STEP: f64 = -2.0 * std::f64::consts::LN_2;
    let exponent = (x.to_bits().wrapping_sub(LOWEST) as i64) >> 52;
    let y = f64::from_bits(x.to_bits().wrapping_sub((exponent << 52) as u64)) - 1.0;
    let y2 = y * y;
    let y4 = y2 * y2;
    let [low, middle, high] = [cubic(0, y, y2), cubic(4, y, y2), cubic(8, y, y2)];
    let polynomial = high.mul_add(y4, middle).mul_add(y4, low);
    y.mul_add(polynomial, exponent as f64 * STEP)
}

/// Four terms of the logarithm's polynomial from coefficient `i` on.
#[inline(always)]
fn cubic(i: usize, y: f64, y2: f64) -> f64 {
    let [a, b, c, d] = [LOG[i], LOG[i + 1], LOG[i + 2], LOG[i + 3]];
    d.mul_add(y, c).mul_add(y2, b.mul_add(y, a))
}

/// sin(π/4 t)/t as a function of t², |t| ≤ 1.
#[inline(always)]
fn sine(x: f64) -> f64 {
    quartic(&SINE, x)
}

/// cos(π/4 t) as a function of t², |t| ≤ 1.
#[inline(always)]
fn cosine(x: f64) -> f64 {
    quartic(&COSINE, x)
}

#[inline(always)]
fn quartic(c: &[f64; 5], x: f64) -> f64 {
    let x2 = x * x;
    c[4].mul_add(x2, c[3].mul_add(x, c[2])).mul_add(x2, c[1].mul_add(x, c[0]))
}

/// Coefficients, lowest first, of the polynomials that interpolate −2 ln(1 + y)/y, sin(π/4 t)/t and cos(π/4 t) at
/// Chebyshev nodes.
const LOG: [f64; 12] = [
    -2.000000000096024,
    1.0000000061691077,
    -0.666666616925635,
    0.49999873171625103,
    -0.40000339275656527,
    0.33340767304756236,
    -0.2856759679739224,
    0.24821771338533505,
    -0.22085471999402412,
    0.2179622503620522,
    -0.21273085067144903,
    0.11691343243638162,
];
const SINE: [f64; 5] = [
    0.7853981633940498,
    -0.08074551201834741,
    0.0024903932101656336,
    -3.6572392613418245e-5,
    3.089966778391475e-7,
];
const COSINE: [f64; 5] = [
    0.9999999999524894,
    -0.30842513515829084,
    0.015854325228446188,
    -0.00032593858594451996,
    3.5297971357780916e-6,
];
