//! The words of `--engine`.

use discovery::engine::Engine;

/// How a diagnosis is decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum EngineWord {
    /// One comparison of hypotheses in nats
    #[default]
    Evidence,
    /// Tests one after another, the previous method: to compare with
    Cascade,
}

impl EngineWord {
    /// `cascade`, `evidence`.
    pub fn name(self) -> &'static str {
        match self {
            EngineWord::Cascade => "cascade",
            EngineWord::Evidence => "evidence",
        }
    }
}

impl From<EngineWord> for Engine {
    fn from(word: EngineWord) -> Self {
        match word {
            EngineWord::Cascade => Engine::Cascade,
            EngineWord::Evidence => Engine::Evidence,
        }
    }
}
