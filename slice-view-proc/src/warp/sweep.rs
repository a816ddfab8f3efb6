//! Runs of pixels of which each says how many after it are as it is.

use std::ops::Range;

/// Runs at a time.
const CHAINS: usize = 8;

/// Goes through all runs of pixels, and leaves none: `look` at one of each, then `apply` what was seen to it and those after it; the next is
/// where that ends. Of several runs at once, as a look takes long and the next in the same run waits for it.
#[inline(always)]
pub(super) fn sweep<T: Copy + Default>(
    runs: &mut Vec<Range<usize>>,
    look: impl Fn(usize) -> T,
    mut apply: impl FnMut(usize, usize, T) -> usize,
) {
    let mut chains: [Range<usize>; CHAINS] = [const { 0..0 }; CHAINS];
    let mut seen = [T::default(); CHAINS];
    loop {
        let mut count = 0;
        for k in 0..CHAINS {
            if chains[k].is_empty() {
                let Some(next) = runs.pop() else {
                    continue;
                };
                chains[k] = next;
            }
            chains.swap(k, count);
            count += 1;
        }
        if count == 0 {
            return;
        }
        for (seen, chain) in seen.iter_mut().zip(&chains[..count]) {
            *seen = look(chain.start);
        }
        for (seen, chain) in seen.iter().zip(&mut chains[..count]) {
            chain.start = apply(chain.start, chain.end, *seen);
        }
    }
}

/// How many places after the first are nearer to it than by the square of a distance, up to one that is not.
#[inline(always)]
pub(super) fn alike(places: &[[f32; 3]], square: f32) -> usize {
    let Some(([x, y, z], rest)) = places.split_first() else {
        return 0;
    };
    let near = |[a, b, c]: &&[f32; 3]| {
        let off = [a - x, b - y, c - z];
        off[0] * off[0] + off[1] * off[1] + off[2] * off[2] < square
    };
    rest.iter().take_while(near).count()
}
