//! Several states on one sheet, and as an animation.

use picture::Canvas;

use super::{Spec, state};
use crate::model::Model;
use crate::run::State;

/// Pixels of the sheet beside and below each picture.
const GAP: u32 = 6;
/// The widest picture of a strip.
const WIDEST: u32 = 340;
/// Pictures in a row.
const ROW: usize = 4;

/// Indices of at most `most` of `count` states: the first, the last, and some evenly between.
pub(crate) fn chosen(count: usize, most: usize) -> Vec<usize> {
    let most = most.clamp(1, count.max(1));
    if count <= most || most == 1 {
        return (count.saturating_sub(most)..count).collect();
    }
    (0..most).map(|k| k * (count - 1) / (most - 1)).collect()
}

/// A strip of states, row after row.
pub(crate) fn strip(model: &Model, states: &[State], spec: &Spec<'_>, most: usize) -> Canvas {
    let shown = chosen(states.len(), most);
    let width = spec.size[0].min(WIDEST);
    let height = (u64::from(spec.size[1]) * u64::from(width) / u64::from(spec.size[0].max(1))).clamp(60, 1000) as u32;
    let small = Spec {
        size: [width, height],
        small: true,
        ..*spec
    };
    let pictures: Vec<Canvas> = shown.into_iter().map(|k| state(model, &states[k], &small)).collect();
    grid(&pictures, ROW)
}

/// Pictures of one size row after row, at most `row` in each.
pub(crate) fn grid(pictures: &[Canvas], row: usize) -> Canvas {
    let (width, height) = pictures.first().map_or((1, 1), |p| (p.width(), p.height()));
    let columns = pictures.len().clamp(1, row);
    let rows = pictures.len().div_ceil(columns).max(1);
    let side = |count: usize, length: u32| GAP + count as u32 * (length + GAP);
    let mut sheet = Canvas::new(side(columns, width), side(rows, height));
    sheet
        .rgba_mut()
        .chunks_exact_mut(4)
        .for_each(|p| p.copy_from_slice(&[205, 205, 205, 255]));
    for (k, picture) in pictures.iter().enumerate() {
        let corner = [side(k % columns, width), side(k / columns, height)];
        sheet.paste(picture.rgba(), picture.width(), corner[0], corner[1]);
    }
    sheet
}

/// The frames of an animation, at most `most`.
pub(crate) fn film(model: &Model, states: &[State], spec: &Spec<'_>, most: usize) -> Vec<Canvas> {
    let size = spec.size.map(|s| (s / 2).max(64));
    let small = Spec {
        size,
        small: true,
        ..*spec
    };
    chosen(states.len(), most)
        .into_iter()
        .map(|k| state(model, &states[k], &small))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::chosen;

    #[test]
    fn first_and_last_are_always_shown() {
        assert_eq!(chosen(3, 6), [0, 1, 2]);
        assert_eq!(chosen(11, 6), [0, 2, 4, 6, 8, 10]);
        assert_eq!(chosen(100, 2), [0, 99]);
        assert_eq!(chosen(5, 1), [4]);
        assert!(chosen(0, 4).is_empty());
    }
}
