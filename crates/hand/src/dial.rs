//! How coarse the sight's drawing is: the miss by pixels of a scale that is compressed outwards, the way to go by those
//! of a bar.

/// The sight's drawing on one screen. Its scale is that of the operator's window, whose test holds the two together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dial {
    /// From the middle to the rim, pixels.
    pub rim_px: f64,
    /// The bar of the way to go, pixels from its lower to its upper end.
    pub bar_px: f64,
    /// What of the bar the white line at zero hides to either side, pixels.
    pub hidden_px: f64,
}

/// Up to this distance the scale is about linear, mm.
const LINEAR_MM: f64 = 5.0;
/// What the rim shows, mm.
const REACH_MM: f64 = 100.0;
/// What the ends of the bar show, mm to go.
const BAR_MM: [f64; 2] = [-10.0, 50.0];

impl Dial {
    /// Eight cells on a monitor of 24 inches and 1920 x 1080 pixels.
    pub const FULL_HD: Self = Self {
        rim_px: 123.590_400_695_800_78,
        bar_px: 243.480_010_986_328_13,
        hidden_px: 2.25,
    };

    /// Where a miss (right, up), mm, is drawn from the middle, pixels (right, up): on the rim where it is beyond.
    pub fn drawn(&self, [right, up]: [f64; 2]) -> [f64; 2] {
        let mm = right.hypot(up);
        if mm == 0.0 {
            return [0.0; 2];
        }
        let part = ((mm / LINEAR_MM).asinh() / (REACH_MM / LINEAR_MM).asinh()).min(1.0);
        [right, up].map(|x| x / mm * part * self.rim_px)
    }

    /// The miss that is drawn at a place: the inverse of [`Dial::drawn`].
    pub fn read(&self, [right, up]: [f64; 2]) -> [f64; 2] {
        let px = right.hypot(up);
        if px == 0.0 {
            return [0.0; 2];
        }
        let mm = LINEAR_MM * (px / self.rim_px * (REACH_MM / LINEAR_MM).asinh()).sinh();
        [right, up].map(|x| x / px * mm)
    }

    /// Pixels of the bar for a millimetre.
    pub fn bar_px_per_mm(&self) -> f64 {
        self.bar_px / (BAR_MM[1] - BAR_MM[0])
    }

    /// The way to go as the bar says it, mm, from the pixels that are filled above zero (below it: negative).
    pub fn to_go(&self, filled_px: f64) -> f64 {
        match filled_px.abs() <= self.hidden_px {
            // Under the white line, which is where it should be.
            true => 0.0,
            false => (filled_px / self.bar_px_per_mm()).clamp(BAR_MM[0], BAR_MM[1]),
        }
    }

    /// A miss as its drawing on whole pixels says it, mm.
    pub fn rounded(&self, miss_mm: [f64; 2]) -> [f64; 2] {
        self.read(self.drawn(miss_mm).map(f64::round))
    }

    /// The way to go as whole pixels of the bar say it, mm.
    pub fn rounded_to_go(&self, to_go_mm: f64) -> f64 {
        self.to_go((to_go_mm * self.bar_px_per_mm()).round())
    }

    /// How far a tip may be off that this drawing shows in the middle, mm: half a pixel right and up, and the line at
    /// zero with half a pixel along.
    pub fn coarseness_mm(&self) -> f64 {
        let [across, _] = self.read([0.5_f64.hypot(0.5), 0.0]);
        across.hypot((self.hidden_px + 0.5) / self.bar_px_per_mm())
    }
}
