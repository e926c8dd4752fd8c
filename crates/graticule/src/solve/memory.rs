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
    let mut values = reserved(count)?;
    values.resize(count, T::default());
    Ok(values)
}

/// Room for so many numbers.
pub(super) fn reserved<T>(count: usize) -> Result<Vec<T>, SolveError> {
    let mut values = Vec::new();
    let done = values.try_reserve_exact(count);
    done.map_err(|_| out_of_memory::<T>(count))?;
    Ok(values)
}

/// Room for so many more numbers.
pub(super) fn reserve<T>(values: &mut Vec<T>, more: usize) -> Result<(), SolveError> {
    let done = values.try_reserve(more);
    done.map_err(|_| out_of_memory::<T>(more))
}

fn out_of_memory<T>(count: usize) -> SolveError {
    SolveError::OutOfMemory {
        bytes: count.saturating_mul(size_of::<T>()),
    }
}
