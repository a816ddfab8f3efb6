//! The ways from the correlation matrix to the rotation.

use nalgebra::Matrix3;

use super::quaternion::{Quaternion, faugeras_hebert, from_matrix, horn};
use super::svd::Decomposition;
use super::{Moments, Refused, SingularValues, newton, polar, rotation_vector};

/// Conditions from here on leave no digit of the rotation: 20 x 2^-53 x condition is a radian.
const MAX_CONDITION: f64 = 1.0 / (20.0 * 0.5 * f64::EPSILON);

/// How the rotation is found. All find the same optimum of 4.13, to the error stated; `c` is the condition number and
/// `u = 2^-53`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// A closed start, Newton's method on the rotations and a proof that the optimum is global; the singular value
    /// decomposition where `c` passes 1e9. Error at most `20 c u`.
    #[default]
    Newton,
    /// Singular value decomposition by one-sided Jacobi (Arun 1987, Umeyama 1991). Error at most `20 c u`; never fails
    /// on a determined set. The most robust, and slower.
    Svd,
    /// Largest eigenvector of the 4 x 4 matrix 4.28 by Jacobi (Horn 1987). Error at most `20 c u`.
    HornQuaternion,
    /// Least eigenvector of the 4 x 4 matrix 4.25 (Faugeras and Hebert 1986). By 4.30 it is Horn's matrix, turned over
    /// and shifted by both energies, and it is formed so here; clouds that fit badly cost digits by the shift.
    FaugerasHebert,
    /// Polar factor through the root of `Psi^T Psi` (Horn 1988, 4.15), completed by the vector product where the rank
    /// is 2 or the optimum is improper (errata 4.15). Squaring costs up to half the digits: error at most `20 c^2 u`,
    /// and [`Refused::MethodFails`] where none is left.
    HornPolar,
    /// The thesis's iteration over axes (4.36 to 4.40, corrected by the errata), started in each of four frames a
    /// half-turn apart until its axis proves to lead to the global optimum, finished by Newton's method; the singular
    /// value decomposition where none does, as for `c` above 1e9. Error at most `20 c u`.
    RotationVector,
}

impl Method {
    /// All methods, the default first.
    pub const ALL: [Self; 6] = [
        Self::Newton,
        Self::Svd,
        Self::HornQuaternion,
        Self::FaugerasHebert,
        Self::HornPolar,
        Self::RotationVector,
    ];
}

impl Moments {
    /// The best rotation as a unit quaternion (w, x, y, z), `To` from `From`.
    ///
    /// # Errors
    /// [`Refused::Collinear`] or [`Refused::Reflected`] where the condition passes 4.5e14, so that no digit would hold;
    /// [`Refused::MethodFails`] where only this method has no answer.
    #[inline]
    pub fn solve(&self, method: Method) -> Result<[f64; 4], Refused> {
        let (psi, bound) = self.normalised();
        if method == Method::Newton {
            return newton::solve(&psi, bound).map_or_else(|| self.by_decomposition(), Ok);
        }
        self.alternative(&psi, bound, method)
    }

    /// The methods other than the default, out of its way.
    #[inline(never)]
    fn alternative(&self, psi: &Matrix3<f64>, bound: f64, method: Method) -> Result<Quaternion, Refused> {
        let found = match method {
            Method::Newton | Method::Svd => return self.by_decomposition(),
            Method::RotationVector => return rotation_vector::solve(psi).map_or_else(|| self.by_decomposition(), Ok),
            Method::HornQuaternion => Some(horn(psi)),
            Method::FaugerasHebert => Some(faugeras_hebert(psi, 2.0 * bound)),
            Method::HornPolar => polar::rotation(psi).and_then(|r| from_matrix(&r)),
        };
        self.checked(found)
    }

    /// Passes on an answer to a problem that has one.
    pub(super) fn checked(&self, found: Option<Quaternion>) -> Result<Quaternion, Refused> {
        let (psi, _) = self.normalised();
        // A method without a proof of its own may hand back one of several optima that are equally good: only where H
        // is safely positive definite is there one optimum.
        if let Some(q) = found.filter(|q| newton::determined(&psi, q)) {
            return Ok(q);
        }
        let values = self.singular_values();
        // First what is wrong with the points: only of a determined set is it the method that failed.
        refuse_undetermined(values)?;
        found.ok_or(Refused::MethodFails(values))
    }

    #[cold]
    #[inline(never)]
    fn by_decomposition(&self) -> Result<Quaternion, Refused> {
        let decomposition = Decomposition::of(&self.correlation());
        refuse_undetermined(decomposition.values)?;
        from_matrix(&decomposition.rotation()).ok_or(Refused::MethodFails(decomposition.values))
    }

    /// The singular values of `Psi`, relative to the clouds' sizes.
    pub fn singular_values(&self) -> SingularValues {
        Decomposition::of(&self.correlation()).values
    }
}

fn refuse_undetermined(values: SingularValues) -> Result<(), Refused> {
    let [s1, s2, _] = values.0;
    if values.condition() < MAX_CONDITION {
        return Ok(());
    }
    // A second value of some size means a plane or a body whose mirror image fits: only the sum with the third
    // vanished.
    // A thousand times the rounding of the second value, so that noise on a line is not called a plane.
    if s2 * MAX_CONDITION > s1 * 1e3 {
        return Err(Refused::Reflected(values));
    }
    Err(Refused::Collinear(values))
}
