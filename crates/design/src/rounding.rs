/// Rounds `shares` (sum 1) to whole numbers that sum to `total` by the efficient apportionment of Pukelsheim & Rieder
/// 1992: every positive share gets at least one if `total` suffices.
pub fn apportion(shares: &[f64], total: u64) -> Vec<u64> {
    let support = shares.iter().filter(|w| **w > 0.0).count() as f64;
    let multiplier = (total as f64 - support / 2.0).max(0.0);
    let mut counts: Vec<u64> = shares.iter().map(|w| (multiplier * w).ceil() as u64).collect();
    let used = || (0..shares.len()).filter(|q| shares[*q] > 0.0);
    let mut sum: u64 = counts.iter().sum();
    while sum > total {
        let surplus = |q: &usize| ((counts[*q] - 1) as f64 / shares[*q], -shares[*q]);
        let Some(most) = used().filter(|q| counts[*q] > 0).max_by(|a, b| compare(surplus(a), surplus(b)))
        else {
            break;
        };
        counts[most] -= 1;
        sum -= 1;
    }
    while sum < total {
        let lack = |q: &usize| (counts[*q] as f64 / shares[*q], -shares[*q]);
        let Some(least) = used().min_by(|a, b| compare(lack(a), lack(b))) else { break };
        counts[least] += 1;
        sum += 1;
    }
    counts
}

fn compare(a: (f64, f64), b: (f64, f64)) -> std::cmp::Ordering {
    a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
}
