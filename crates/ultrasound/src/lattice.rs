//! Cells fixed in the patient: what is drawn from a cell's number is there again when the probe comes back.

use chance::mix;

use crate::fan::Fan;
use crate::scene::Pose;

/// Cubes of one size, counted from the patient's origin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lattice {
    pub(crate) cell_mm: f64,
    pub(crate) seed: u64,
}

impl Lattice {
    /// 64 bits that belong to a cell.
    pub(crate) fn bits(&self, cell: [i64; 3]) -> u64 {
        // Odd factors keep the cells of a line, a plane and space apart; `mix` spreads what is left.
        let [x, y, z] = cell.map(|part| part as u64);
        let number = x
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .wrapping_add(y.wrapping_mul(0xc2b2_ae3d_27d4_eb4f))
            .wrapping_add(z.wrapping_mul(0x1656_67b1_9e37_79f9));
        mix(number ^ self.seed)
    }

    /// The cell of a place.
    pub(crate) fn cell(&self, place: [f64; 3]) -> [i64; 3] {
        place.map(|part| (part / self.cell_mm).floor() as i64)
    }

    /// A number from 0 to 1 that changes smoothly from cell to cell.
    pub(crate) fn smooth(&self, place: [f64; 3]) -> f64 {
        let scaled = place.map(|part| part / self.cell_mm);
        let low = scaled.map(|part| part.floor() as i64);
        // Perlin's cubic: flat at the corners.
        let ease: [f64; 3] = std::array::from_fn(|i| {
            let part = scaled[i] - low[i] as f64;
            part * part * (3.0 - 2.0 * part)
        });
        let corner = |corner: usize| {
            let up = |i: usize| (corner >> i) & 1;
            let weight: f64 = (0..3)
                .map(|i| if up(i) == 1 { ease[i] } else { 1.0 - ease[i] })
                .product();
            let bits = self.bits(std::array::from_fn(|i| low[i] + up(i) as i64));
            weight * (bits >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..8).map(corner).sum()
    }

    /// Visits every cell whose middle is over the image and within `reach(depth as shown)` of its plane, in one order.
    ///
    /// Beyond the outermost beams and depths another `reach` of cells is visited.
    pub(crate) fn visit(&self, pose: &Pose, fan: &Fan, reach: impl Fn(f64) -> f64, mut visit: impl FnMut([i64; 3])) {
        let across = pose.across();
        // Columns of cells run along the axis that is most nearly square to the image, so that they are short.
        let axis = (0..3).fold(0, |best, i| if across[i].abs() > across[best].abs() { i } else { best });
        let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
        let depth = fan.shape.depth_mm();
        let most = [0.0, depth].map(&reach).into_iter().fold(0.0, f64::max);
        let (low, high) = bounds(pose, fan, most);
        let span = |i: usize| {
            let ends = [low[i], high[i]].map(|end: f64| (end / self.cell_mm).floor() as i64);
            ends[0]..=ends[1]
        };
        let middle = |index: i64| (index as f64 + 0.5) * self.cell_mm;
        let margin = most + self.cell_mm;
        for i in span(first) {
            for j in span(second) {
                let mut place = [0.0; 3];
                place[first] = middle(i);
                place[second] = middle(j);
                // Where the column meets the plane.
                let aside = pose.inside(place)[2];
                place[axis] = -aside / across[axis];
                let [x, y, _] = pose.inside(place);
                let (beam, shown) = fan.locate([x, y]);
                let beams = margin / fan.pitch_mm(shown.max(0.0));
                let outside = beam < -beams || beam > fan.beams as f64 + beams;
                if outside || shown < -margin || shown > depth + margin {
                    continue;
                }
                let half = reach(shown.clamp(0.0, depth)) / across[axis].abs();
                let [from, to] = [place[axis] - half, place[axis] + half];
                let [from, to] = [from, to].map(|end| (end / self.cell_mm).floor() as i64);
                for k in from..=to {
                    let mut cell = [0; 3];
                    (cell[first], cell[second], cell[axis]) = (i, j, k);
                    visit(cell);
                }
            }
        }
    }
}

/// The box around the image, `margin` thick.
fn bounds(pose: &Pose, fan: &Fan, margin: f64) -> ([f64; 3], [f64; 3]) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    // A curved array's border bulges between its corners: many points of it.
    for step in 0..=32 {
        let beam = f64::from(step) / 32.0 * (fan.beams - 1) as f64;
        for shown in [0.0, fan.shape.depth_mm()] {
            let place = pose.place(fan.at(beam, shown).0);
            for i in 0..3 {
                low[i] = low[i].min(place[i]);
                high[i] = high[i].max(place[i]);
            }
        }
    }
    // Between two of 33 points an arc of at most half a turn rises by 1 - cos(1.55 / 32), a thousandth of its radius.
    let more = margin + 0.002 * (fan.shape.depth_mm() + 200.0);
    (low.map(|part| part - more), high.map(|part| part + more))
}
