//! What the worker calls.
#![allow(
    unsafe_code,
    reason = "names that a host finds; every access is checked"
)]

use std::cell::RefCell;

use crate::Playground;

#[link(wasm_import_module = "host")]
unsafe extern "C" {
    /// What is to be drawn now.
    safe fn published(address: *const u8, length: usize);
}

thread_local! {
    static PLAYGROUND: RefCell<Playground> = RefCell::default();
    static QUESTION: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static ANSWER: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Where a question of so many bytes is to be written.
#[unsafe(no_mangle)]
pub extern "C" fn reserve(length: usize) -> *mut u8 {
    QUESTION.with_borrow_mut(|question| {
        question.clear();
        question.resize(length, 0);
        question.as_mut_ptr()
    })
}

/// Answers the question: 1, or 0 where the answer says why there is none.
#[unsafe(no_mangle)]
pub extern "C" fn ask() -> u32 {
    let question = QUESTION.take();
    let mut publish = |bytes: &[u8]| published(bytes.as_ptr(), bytes.len());
    let answer = PLAYGROUND.with_borrow_mut(|p| p.answer(&question, &mut publish));
    let is_answer = answer.is_ok();
    ANSWER.set(answer.unwrap_or_else(String::into_bytes));
    u32::from(is_answer)
}

/// Where the answer is.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    ANSWER.with_borrow(|answer| answer.as_ptr())
}

/// How many bytes it has.
#[unsafe(no_mangle)]
pub extern "C" fn answer_length() -> usize {
    ANSWER.with_borrow(Vec::len)
}
