//! What is said on standard error. Where nobody reads that any more it is lost: it must not end
//! what is being done, as the standard library's macros do.

/// Says a line.
macro_rules! say {
    ($($what:tt)*) => {{
        use std::io::Write;
        let _ = writeln!(std::io::stderr(), $($what)*);
    }};
}
