//! A claim: a number and the band it must lie in. Laws are lists of claims, so that a fault can be
//! shown to break them.

/// One statement about a number; a number that does not exist breaks it.
#[derive(Clone, Debug)]
pub struct Claim {
    pub what: String,
    pub value: Option<f64>,
    pub low: f64,
    pub high: f64,
}

impl Claim {
    pub fn at_most(what: impl Into<String>, value: impl Into<Option<f64>>, high: f64) -> Self {
        Self { what: what.into(), value: value.into(), low: f64::NEG_INFINITY, high }
    }

    pub fn within(what: impl Into<String>, value: impl Into<Option<f64>>, low: f64, high: f64) -> Self {
        Self { what: what.into(), value: value.into(), low, high }
    }

    fn holds(&self) -> bool {
        self.value.is_some_and(|value| value >= self.low && value <= self.high)
    }
}

/// What is broken, in words.
pub fn broken(claims: &[Claim]) -> Vec<String> {
    let say = |claim: &Claim| format!("{}: {:?} not in [{:.4}, {:.4}]", claim.what, claim.value, claim.low, claim.high);
    claims.iter().filter(|claim| !claim.holds()).map(say).collect()
}

/// # Panics
/// When a claim is broken.
pub fn demand(claims: &[Claim]) {
    let broken = broken(claims);
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}
