/// An enum of choices with the same names in files, on the command line and on pages. Each name is stated
/// once, and so is its meaning: a variant's doc comment without the full stop is its line in `--help`.
///
/// Defines `ALL`, `name`, `description`, `Display` and the names for `serde` and `schemars`, which the caller must depend on.
#[macro_export]
macro_rules! choices {
    (
        $(#[$about:meta])*
        pub enum $Choices:ident {
            $($(#[doc = $line:literal])+ $Choice:ident = $name:literal,)+
        }
    ) => {
        $(#[$about])*
        #[derive(
            Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
        )]
        pub enum $Choices {
            $($(#[doc = $line])+ #[serde(rename = $name)] $Choice,)+
        }

        impl $Choices {
            /// All of them.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$Choice),+];

            /// Its name in files and on the command line.
            pub fn name(self) -> &'static str {
                [$($name),+][self as usize]
            }

            /// Its description in one line.
            pub fn description(self) -> &'static str {
                [$(concat!($($line),+)),+][self as usize].trim_start().trim_end_matches('.')
            }
        }

        impl std::fmt::Display for $Choices {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}
