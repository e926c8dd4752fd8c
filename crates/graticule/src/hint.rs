/// What a user can do about an error.
///
/// An error's `Display` states one fact: which element, which number, which rule. The hint is
/// kept apart from it so that a caller can show it on a line of its own.
pub trait Hint {
    /// One sentence that says what to do, or `None` where nothing useful can be said.
    fn hint(&self) -> Option<String>;
}
