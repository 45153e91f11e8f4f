use numerics::{LANES, Lane, vectorized};
use rand::Rng;

/// Standard normal numbers, two at a time, for a lane of runs: every run draws from a Xoshiro256++ generator
/// of its own, by the method of Box and Muller.
///
/// The functions in it are polynomials with a relative error below 1.2e-10; they use only additions and
/// multiplications, fused exactly where written so, and a square root, so that all instruction sets give the
/// same bits. No number exceeds 8.5.
#[derive(Clone, Debug)]
pub(crate) struct Normals {
    /// Word by word, in the layout of vectors.
    state: [[u64; LANES]; 4],
}

impl Normals {
    /// Seeded by 32 bytes per lane.
    pub(crate) fn seeded(seeds: [&[u8; 32]; LANES]) -> Self {
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
