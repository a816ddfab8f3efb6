//! How far places of a surface are from its nearest point: what is so small may lie between points unseen.

/// Points are at something nearer than so many of their gaps, half of the way to the next.
const SEEN_AT: f64 = 2.0;

/// How far the middle between points of such an area is from them, mm: of Gauss points of a square the middle of four is three quarters of the root of their
/// area away.
pub(super) fn gap_of(area: f64) -> f64 {
    0.75 * area.sqrt()
}

/// How far the middle between points may be from them, where they are at something, mm: `gap` is half of the way to the next.
pub(super) fn gap_at(gap: f64, distance: f64) -> f64 {
    if distance < SEEN_AT * gap { gap } else { 0.0 }
}

/// Points are at something rigid nearer than this, mm: within its radius, however far points there are apart.
pub(super) fn seen_from(radius: f64, gap: f64) -> f64 {
    radius.max(SEEN_AT * gap)
}

/// The half of the way to the next point on the straight way from rest, where the surface is stretched by this at its end, mm.
pub(super) fn widest_on_the_way(gap: f64, stretch: f64) -> f64 {
    // Deformation gradients on the way are means of the last one and none.
    gap * stretch.max(1.0)
}
