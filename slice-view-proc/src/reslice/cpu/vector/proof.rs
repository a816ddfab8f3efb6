//! The proof that this CPU has AVX2, and what needs no more than it.

/// Proof that this CPU has AVX2.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vector(());

impl Vector {
    /// Whether this CPU has it.
    pub(crate) fn detect() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            return Some(Self(()));
        }
        None
    }

    /// Runs `work` compiled for AVX2 where there is a proof, else as it is.
    #[inline(always)]
    pub(crate) fn with(vector: Option<Self>, work: impl FnOnce()) {
        match vector {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the proof says that this CPU has AVX2.
            Some(Self(())) => unsafe { run(work) },
            _ => work(),
        }
    }

    /// The same of long work: that of a closure is compiled for AVX2 only where the compiler takes it in.
    #[inline(always)]
    pub(crate) fn work(vector: Option<Self>, work: impl Work) {
        match vector {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the proof says that this CPU has AVX2.
            Some(Self(())) => unsafe { run_long(work) },
            _ => work.work(),
        }
    }

    /// Asks for the memory of `N` values from place `from` on, if there are so many.
    #[inline(always)]
    pub(crate) fn fetch<const N: usize, V>(self, values: &[V], from: usize) {
        #[cfg(target_arch = "x86_64")]
        if let Some(values) = values.get(from..).and_then(|rest| rest.first_chunk::<N>()) {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            let (first, bytes) = (values.as_ptr().cast::<i8>(), size_of_val(values));
            // The last byte as well: values need not begin where cache lines do.
            for at in (0..bytes).step_by(64).chain([bytes - 1]) {
                // SAFETY: fetching reads nothing, and the address is within the values.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(first.add(at)) };
            }
        }
    }

    /// Asks for the memory of the value at `place`, if there is one.
    #[inline(always)]
    pub(crate) fn fetch_one<V>(self, values: &[V], place: usize) {
        #[cfg(target_arch = "x86_64")]
        if let Some(value) = values.get(place) {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            // SAFETY: fetching reads nothing, and the address is that of a value.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(value).cast()) };
        }
    }
}

/// Work whose functions are all marked to be taken in where they are called.
pub(crate) trait Work {
    /// Does it.
    fn work(self);
}

/// Compiles what it is given for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_long(work: impl Work) {
    work.work();
}

/// Compiles what it is given for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run(work: impl FnOnce()) {
    work();
}
