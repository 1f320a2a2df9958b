//! Diagnoses by evidence.
