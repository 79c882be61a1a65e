//! Tests of the whole house live beside this file; the crate itself is empty.
