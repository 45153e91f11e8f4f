//! Logs, and chains of instruments that make them.

mod chain;
mod oracle;
mod oracle_chain;
