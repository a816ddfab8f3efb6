//! `L D L^T` of a sparse symmetric matrix.

use std::num::NonZeroUsize;

use nalgebra::DMatrix;

use super::Triplets;
use super::numbers::{Matrix, Values};
use super::order::Dissection;
use super::parallel::Workers;
use super::store::{Form, Precision, Store};
use super::symbolic::Symbolic;

/// Patterns that are joined before the oldest are forgotten.
const MOST_JOINED: usize = 8;

/// The signs of the pivots, which are those of the eigenvalues.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Inertia {
    /// Pivots above zero.
    pub positive: usize,
    /// Pivots below zero.
    pub negative: usize,
}

/// A pivot vanished: the matrix, or a leading block of it, is singular.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the pivot of unknown {unknown} is {pivot:e}, nothing beside its diagonal entry {diagonal:e}: the matrix is singular"
)]
pub struct NoPivot {
    /// The unknown whose pivot it is.
    pub unknown: usize,
    /// The pivot.
    pub pivot: f64,
    /// The diagonal entry that it comes from.
    pub diagonal: f64,
}

/// A factorisation that remembers the pattern it met last, so that a matrix of the same pattern costs no search.
///
/// Multifrontal (Duff and Reid 1983): unknowns with the same rows below are eliminated together, in a dense matrix that takes
/// up what those before it left behind. On a mesh the first ones are the elements, whose inner nodes are thus condensed.
#[derive(Debug, Clone, Default)]
pub struct Ldl {
    /// None: minimum degree.
    dissection: Option<Dissection>,
    precision: Precision,
    /// None: one.
    threads: Option<NonZeroUsize>,
    places: Vec<(u32, u32)>,
    /// The place in the fronts' columns that each triplet adds to, and the entry of the matrix that this is.
    slots: Vec<u32>,
    entry_of: Vec<u32>,
    /// The places that the elimination was found for: those of several matrices.
    pattern: Vec<(u32, u32)>,
    pub(super) joined: usize,
    pub(super) symbolic: Symbolic,
    /// The matrix taken up last.
    matrix: Values,
    /// The columns of all fronts: `L`, and the pivots.
    pub(super) store: Store,
    /// What a shift is multiplied by, unknown by unknown; none: 1.
    weights: Vec<f64>,
    /// What is added to the diagonal, in the order of elimination.
    shifts: Vec<f64>,
    /// What the elimination of all others leaves on the root.
    pub(super) root: DMatrix<f64>,
    pub(super) workers: Workers<f64>,
    singles: Workers<f32>,
}

impl Ldl {
    /// A factorisation of nothing yet, which orders by minimum degree: for patterns that change.
    pub fn new() -> Self {
        Self::default()
    }

    /// The same by nested dissection, for meshes in space.
    ///
    /// A matrix of another size than that of the dissection is dissected by its pattern alone and keeps no root.
    pub fn ordered_by(dissection: Dissection) -> Self {
        Self {
            dissection: Some(dissection),
            ..Self::default()
        }
    }

    /// How entries are stored for solutions, from the next factorisation on.
    pub fn set_precision(&mut self, precision: Precision) {
        self.precision = precision;
    }

    /// How many threads eliminate, each subtrees of its own: with any number the bits are the same.
    pub fn set_threads(&mut self, threads: NonZeroUsize) {
        self.threads = Some(threads);
    }

    /// The unknowns in the order of their elimination.
    pub fn order(&self) -> &[u32] {
        &self.symbolic.order
    }

    /// Factors `matrix + shift I`. Without pivoting: exact for definite matrices, and for others while no leading block
    /// in the order of elimination is near singular; [`Self::solve`]'s residual tells.
    ///
    /// # Errors
    /// [`NoPivot`], also where an entry is not a number.
    pub fn factor(&mut self, matrix: &Triplets, shift: f64) -> Result<Inertia, NoPivot> {
        self.take(matrix);
        self.shifted(shift)
    }

    /// Shifts from here on are `shift` times these on the diagonal, by unknown; of none of them times 1.
    pub fn weigh(&mut self, weights: &[f64]) {
        self.weights.clear();
        self.weights.extend_from_slice(weights);
    }

    /// Takes up a matrix, to be factored with several shifts.
    pub fn take(&mut self, matrix: &Triplets) {
        let size = matrix.size();
        if self.symbolic.order.len() != size || self.places != matrix.places {
            self.learn(size, &matrix.places);
        }
        self.matrix.values.fill(0.0);
        for (entry, value) in self.entry_of.iter().zip(&matrix.values) {
            self.matrix.values[*entry as usize] += value;
        }
    }

    /// Factors the matrix taken up last, and `shift I`, as [`Self::factor`] does.
    ///
    /// # Errors
    /// [`NoPivot`].
    pub fn shifted(&mut self, shift: f64) -> Result<Inertia, NoPivot> {
        self.shift(shift);
        let negative = self.eliminate(usize::MAX)?;
        Ok(Inertia {
            positive: self.shifts.len() - negative,
            negative,
        })
    }

    /// The same, but at the first negative pivot it ends: true where the matrix is definite. After false
    /// [`Self::falling_direction`] has an answer, and [`Self::solve`] none.
    ///
    /// # Errors
    /// [`NoPivot`].
    pub fn definite(&mut self, shift: f64) -> Result<bool, NoPivot> {
        self.shift(shift);
        Ok(self.eliminate(1)? == 0)
    }

    /// Where the entries of a new pattern go. Contacts come and go: the elimination is kept while it has a place for each,
    /// and found anew for both patterns together where it has not.
    fn learn(&mut self, size: usize, places: &[(u32, u32)]) {
        let known = self.symbolic.order.len() == size && size > 0;
        if !(known && self.find_slots(places)) {
            // A pattern that only grew would keep room, and work, for contacts long gone.
            if !known || self.joined >= MOST_JOINED {
                self.pattern.clear();
                self.joined = 0;
            }
            self.joined += 1;
            // Patterns mostly begin alike: what they share is not put in twice.
            let same = common(&self.pattern, places);
            self.pattern.extend_from_slice(&places[same..]);
            self.symbolic = Symbolic::new(size, &self.pattern, self.dissection.as_ref());
            // Slots in the old elimination say nothing about the new one.
            self.places.clear();
            // Every place was put in above.
            self.find_slots(places);
        }
        let known = self.places.len();
        self.places.extend_from_slice(&places[known..]);
        self.gather();
    }

    /// The entries that the slots are of.
    fn gather(&mut self) {
        // A bit for each place: its rank among those that are set is the entry's number.
        let mut bits = vec![0_u64; self.symbolic.entries.div_ceil(64)];
        for slot in &self.slots {
            bits[*slot as usize / 64] |= 1 << (slot % 64);
        }
        let mut ranks = Vec::with_capacity(bits.len());
        let places = &mut self.matrix.places;
        places.clear();
        for (k, word) in bits.iter().enumerate() {
            ranks.push(places.len() as u32);
            let mut rest = *word;
            while rest != 0 {
                places.push(64 * k as u32 + rest.trailing_zeros());
                rest &= rest - 1;
            }
        }
        let rank = |slot: &u32| {
            let before = bits[*slot as usize / 64] & ((1 << (slot % 64)) - 1);
            ranks[*slot as usize / 64] + before.count_ones()
        };
        self.entry_of.clear();
        self.entry_of.extend(self.slots.iter().map(rank));
        self.matrix.starts = self.symbolic.starts_among(&self.matrix.places);
        self.matrix.values.resize(self.matrix.places.len(), 0.0);
    }

    /// The slots of these places; those that begin as the last ones did are known. False where the elimination lacks one.
    fn find_slots(&mut self, places: &[(u32, u32)]) -> bool {
        let same = common(&self.places, places);
        self.slots.truncate(same);
        self.places.truncate(same);
        for place in &places[same..] {
            match self.symbolic.slot(*place) {
                Some(slot) => self.slots.push(slot),
                None => return false,
            }
        }
        true
    }

    /// Entries of `L` below the diagonal.
    pub fn fill(&self) -> usize {
        let fronts = self.symbolic.fronts.iter();
        fronts.map(|f| f.width * (f.width - 1) / 2 + f.width * f.height).sum()
    }

    /// Multiplications of a factorisation.
    pub fn work(&self) -> usize {
        let columns = self
            .symbolic
            .fronts
            .iter()
            .flat_map(|f| (0..f.width).map(|k| f.size() - 1 - k));
        // A column of `c` entries takes `c` for its pivot, and `c (c + 1) / 2` for the triangle it is taken from.
        columns.map(|c| c * (c + 3) / 2).sum()
    }

    fn shift(&mut self, shift: f64) {
        let weight = |unknown: &u32| self.weights.get(*unknown as usize).copied().unwrap_or(1.0);
        self.shifts.clear();
        self.shifts
            .extend(self.symbolic.order.iter().map(|u| shift * weight(u)));
    }

    /// Front by front. How many pivots are negative; once they are `most`, the rest is left as it is.
    fn eliminate(&mut self, most: usize) -> Result<usize, NoPivot> {
        let (symbolic, root, store) = (&self.symbolic, &mut self.root, &mut self.store);
        let mut matrix = Matrix {
            symbolic,
            values: &self.matrix,
            shifts: &self.shifts,
            scale: 1.0,
        };
        let threads = self.threads.map_or(1, usize::from);
        // Paths of contacts in the plane rest on the rounding of the unpacked one.
        let form = match self.precision {
            Precision::Double if self.dissection.is_none() => Form::Whole,
            Precision::Double => Form::Double,
            Precision::Single | Precision::SingleThroughout => Form::Single,
        };
        store.set(form);
        let found = match (self.precision, form) {
            (Precision::SingleThroughout, _) => {
                matrix.scale = matrix.unit();
                let place = store.single.packed(symbolic);
                self.singles.eliminate(matrix, place, root, most, threads)
            }
            (_, Form::Single) => {
                let place = store.single.packed(symbolic);
                self.workers.eliminate(matrix, place, root, most, threads)
            }
            (_, Form::Double) => {
                let place = store.double.packed(symbolic);
                self.workers.eliminate(matrix, place, root, most, threads)
            }
            (_, Form::Whole) => {
                let place = store.double.whole(symbolic);
                self.workers.eliminate(matrix, place, root, most, threads)
            }
        };
        found.map_err(|(front, (column, pivot, diagonal))| NoPivot {
            unknown: symbolic.order[symbolic.fronts[front].first + column] as usize,
            pivot,
            diagonal,
        })
    }
}

/// How many places two lists have in common at their beginning.
fn common(one: &[(u32, u32)], other: &[(u32, u32)]) -> usize {
    one.iter().zip(other).take_while(|(a, b)| a == b).count()
}
