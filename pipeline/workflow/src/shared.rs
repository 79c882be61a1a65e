//! Shared: a value that many subjects hold, with the hash of its content.

use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use serde::Serialize;

/// A shared value, which enters a key by its hash: a table over all trials would otherwise hold its card once for each of them.
#[derive(Debug)]
pub struct Shared<T>(Arc<(T, OnceLock<String>)>);

impl<T> From<T> for Shared<T> {
    fn from(value: T) -> Self {
        Self(Arc::new((value, OnceLock::new())))
    }
}

impl<T: Serialize> Shared<T> {
    /// BLAKE3 of the value's JSON, in hexadecimal digits; computed once.
    pub fn digest(&self) -> &str {
        let text = || serde_json::to_vec(&self.0.0).unwrap_or_default();
        self.0.1.get_or_init(|| blake3::hash(&text()).to_hex().to_string())
    }
}

impl<T> Clone for Shared<T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<T> Deref for Shared<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0.0
    }
}

impl<T> AsRef<T> for Shared<T> {
    fn as_ref(&self) -> &T {
        &self.0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_values_have_one_digest_and_others_another() {
        let [a, b, c] = [1, 1, 2].map(|value| Shared::from(vec![value; 3]));
        assert_eq!(a.digest(), b.clone().digest());
        assert_ne!(a.digest(), c.digest());
        assert_eq!((a.len(), a.digest().len()), (3, 64));
    }
}
