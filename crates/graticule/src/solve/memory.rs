//! Memory for factors, or an error where it is short.

use faer::dyn_stack::{MemBuffer, StackReq};

use super::SolveError;

/// Scratch memory.
pub(super) fn memory(scratch: StackReq) -> Result<MemBuffer, SolveError> {
    let bytes = scratch.unaligned_bytes_required();
    MemBuffer::try_new(scratch).map_err(|_| SolveError::OutOfMemory { bytes })
}

/// Zeros.
pub(super) fn zeros<T: Clone + Default>(count: usize) -> Result<Vec<T>, SolveError> {
    let mut values = Vec::new();
    values
        .try_reserve_exact(count)
        .map_err(|_| SolveError::OutOfMemory {
            bytes: count.saturating_mul(size_of::<T>()),
        })?;
    values.resize(count, T::default());
    Ok(values)
}
