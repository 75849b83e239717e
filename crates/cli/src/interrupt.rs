//! Ctrl-C: work that can be stopped ends in order, and leaves nothing half-written.

use std::sync::OnceLock;

use csg::CancelToken;

use crate::failure::exit_codes::INTERRUPTED;

/// What Ctrl-C cancels from now on; pressed a second time, it ends the program at once.
pub(crate) fn token() -> CancelToken {
    static TOKEN: OnceLock<CancelToken> = OnceLock::new();
    let made = TOKEN.get_or_init(|| {
        let token = CancelToken::new();
        let cancelled = token.clone();
        // (Where a program that calls us has a handler of its own, it stays.)
        let _ = ctrlc::try_set_handler(move || {
            if cancelled.is_cancelled() {
                std::process::exit(INTERRUPTED.into());
            }
            cancelled.cancel();
        });
        token
    });
    made.clone()
}
