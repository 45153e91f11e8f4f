//! Nothing: its dependencies ask for the features that a build of the whole workspace unites.
