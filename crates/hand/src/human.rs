//! What is taken from the literature on people: every constant in one place, with its source.

/// An operator. [`Human::default`] is the one of the study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Human {
    /// From the end of a look to the beginning of the stroke that it leads to, s. 0.2: McRuer and Jex 1967, the
    /// effective delay of a person who tracks by eye and hand.
    pub reaction_s: f64,
    /// How long a look takes, s: what is shown meanwhile is seen as one. 0.1: Card, Moran and Newell 1983, the
    /// perceptual processor's cycle.
    pub look_s: f64,
    /// From one picture to another, s: the eye's jump and finding one's way on the new picture. 0.3: Card, Moran and
    /// Newell 1983, 0.23 for the eye and 0.07 for one cycle of thought.
    pub glance_s: f64,
    /// How long the display has to say that the tip has arrived before she lets go, s. 0.5: an assumption.
    pub dwell_s: f64,
    /// She does not let go before what she sees is off by no more than this, mm, whatever the display says. No bound:
    /// its word is enough.
    pub content_mm: f64,
    /// Standard deviation of a stroke's end along it, parts of its length; across it is half of that (Gordon, Ghilardi
    /// and Ghez 1994 have ellipses of about that shape). 0.07: Card, Moran and Newell 1983, after Vince 1948, what each
    /// correction leaves over.
    pub scatter: f64,
    /// Time for a bit of a stroke's accuracy, s. 0.1: Fitts 1954, Card, Moran and Newell 1983.
    pub bit_s: f64,
    /// The tube is pushed no faster than this in the mean of a stroke, mm/s. 20: an assumption, the pace of the
    /// demonstration's gesture.
    pub advance_mm_s: f64,
    /// The axis may pass beside the target under this angle while the tube advances, rad; beyond, it is turned first. 5
    /// degrees: the window's own limit.
    pub align_rad: f64,
    /// Tremor of the hand, root mean square along each axis, mm. 0.07: Riviere, Rader and Khosla 1997 found 0.05 where
    /// eye surgeons hold an instrument still and 0.13 where they move it.
    pub tremor_mm: f64,
    /// Its band, Hz. 8 to 12: physiological tremor of the hand (Elble and Koller 1990).
    pub tremor_hz: [f64; 2],
    /// Whether she knows of the added lag and waits until the picture stands still (Ferrell 1965: move and wait), or
    /// looks as early as she would without it.
    pub knows_lag: bool,
}

impl Default for Human {
    fn default() -> Self {
        Self {
            reaction_s: 0.2,
            look_s: 0.1,
            glance_s: 0.3,
            dwell_s: 0.5,
            content_mm: f64::INFINITY,
            scatter: SCATTER,
            bit_s: 0.1,
            advance_mm_s: 20.0,
            align_rad: 5.0_f64.to_radians(),
            tremor_mm: 0.07,
            tremor_hz: [8.0, 12.0],
            knows_lag: true,
        }
    }
}

const SCATTER: f64 = 0.07;
/// From a normal error's deviation to the width that holds 96 % of it: `sqrt(2 pi e)`, the effective width of a target
/// (MacKenzie 1992).
const EFFECTIVE_WIDTH: f64 = 4.132_731_354_122_493;

impl Human {
    /// Without scatter and without tremor: what a loop reaches that errs by its display alone.
    pub fn steady() -> Self {
        Self {
            scatter: 0.0,
            tremor_mm: 0.0,
            ..Self::default()
        }
    }

    /// How long a stroke takes that pushes the tube by `ahead_mm`, s.
    ///
    /// By Fitts' law `bit log2(2 A / W)`, with the width `W = 4.13 scatter A` that the stroke's own ends have: the same
    /// for every length `A` (0.28 s), as strokes of people are that have no time to be corrected (Fitts and Peterson
    /// 1964). Pushing has a limit besides.
    pub fn stroke_s(&self, ahead_mm: f64) -> f64 {
        // A steady hand is as fast as one that is not.
        let scatter = if self.scatter > 0.0 { self.scatter } else { SCATTER };
        let aimed = self.bit_s * (2.0 / (EFFECTIVE_WIDTH * scatter)).log2().max(1.0);
        aimed.max(ahead_mm.abs() / self.advance_mm_s)
    }

    /// Which part of the way ahead she aims for: two deviations short, so that one stroke in 44 goes too far.
    pub fn caution(&self) -> f64 {
        1.0 - 2.0 * self.scatter
    }
}
