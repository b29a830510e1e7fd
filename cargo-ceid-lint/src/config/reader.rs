//! Walks a TOML table key by key, so that every error has the place of the very word that is wrong.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{ConfigError, Place};

/// The file that is read.
#[derive(Clone, Copy)]
pub(crate) struct File<'a> {
    pub(crate) path: &'a Path,
    pub(crate) text: &'a str,
}

impl File<'_> {
    pub(crate) fn place(&self, range: Range<usize>) -> Place {
        Place::new(self.path, self.text, range)
    }

    pub(crate) fn error(&self, range: Range<usize>, message: impl Into<String>) -> ConfigError {
        ConfigError::at(self.place(range), message)
    }

    /// What is no TOML.
    pub(crate) fn syntax_error(&self, error: &toml::de::Error) -> ConfigError {
        // The place of a NUL byte is one that nobody sees.
        if let Some(at) = self.text.find('\0') {
            let error = self.error(at..at + 1, "the file holds a NUL byte, which TOML forbids");
            return error.help("remove the byte, or write the file anew as plain text");
        }
        self.error(error.span().unwrap_or(0..0), error.message().trim().to_owned())
    }

    fn expected(&self, value: &Spanned<DeValue<'_>>, what: &str) -> ConfigError {
        self.error(value.span(), format!("expected {what}, found {}", described(value.get_ref())))
    }
}

fn described(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) => "an integer",
        DeValue::Float(_) => "a float",
        DeValue::Boolean(_) => "a boolean",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

/// A value with its file.
#[derive(Clone, Copy)]
pub(crate) struct Value<'a> {
    pub(crate) file: File<'a>,
    pub(crate) value: &'a Spanned<DeValue<'a>>,
}

impl<'a> Value<'a> {
    pub(crate) fn place(self) -> Place {
        self.file.place(self.value.span())
    }

    pub(crate) fn error(self, message: impl Into<String>) -> ConfigError {
        self.file.error(self.value.span(), message)
    }

    pub(crate) fn string(self) -> Result<&'a str, ConfigError> {
        self.value.get_ref().as_str().ok_or_else(|| self.file.expected(self.value, "a string"))
    }

    pub(crate) fn integer(self) -> Result<i64, ConfigError> {
        let integer = self.value.get_ref().as_integer().ok_or_else(|| self.file.expected(self.value, "an integer"))?;
        i64::from_str_radix(&integer.as_str().replace('_', ""), integer.radix())
            .map_err(|_| self.error("this integer is too large"))
    }

    pub(crate) fn index(self) -> Result<u32, ConfigError> {
        u32::try_from(self.integer()?)
            .map_err(|_| self.error("expected the position of an argument, which is 0 or more"))
    }

    pub(crate) fn list(self) -> Result<Vec<Self>, ConfigError> {
        let list = self.value.get_ref().as_array().ok_or_else(|| self.file.expected(self.value, "a list"))?;
        Ok(list.iter().map(|value| Self { file: self.file, value }).collect())
    }

    /// A list, or one value that stands for a list of one.
    pub(crate) fn list_or_one(self) -> Vec<Self> {
        self.list().unwrap_or_else(|_| vec![self])
    }

    pub(crate) fn strings(self) -> Result<Vec<String>, ConfigError> {
        let is_list = self.value.get_ref().is_array();
        if !is_list && !self.value.get_ref().is_str() {
            return Err(self.file.expected(self.value, "a string or a list of strings"));
        }
        self.list_or_one().into_iter().map(|value| Ok(value.string()?.to_owned())).collect()
    }

    pub(crate) fn is_table(self) -> bool {
        self.value.get_ref().is_table()
    }

    pub(crate) fn table(self, what: &str) -> Result<Table<'a>, ConfigError> {
        let table = self.value.get_ref().as_table().ok_or_else(|| self.file.expected(self.value, what))?;
        Ok(Table { file: self.file, table, range: self.value.span() })
    }

    /// One of a few words.
    pub(crate) fn choice<T: Copy>(self, choices: &[(&str, T)]) -> Result<T, ConfigError> {
        let word = self.string()?;
        choices.iter().find(|(name, _)| *name == word).map(|(_, value)| *value).ok_or_else(|| {
            let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
            self.error(format!("unknown value `{word}`")).did_you_mean(word, &names)
        })
    }
}

/// A table with its file.
#[derive(Clone)]
pub(crate) struct Table<'a> {
    pub(crate) file: File<'a>,
    pub(crate) table: &'a DeTable<'a>,
    pub(crate) range: Range<usize>,
}

impl<'a> Table<'a> {
    pub(crate) fn place(&self) -> Place {
        self.file.place(self.range.clone())
    }

    pub(crate) fn get(&self, key: &str) -> Option<Value<'a>> {
        self.table.get(key).map(|value| Value { file: self.file, value })
    }

    /// All keys with their places, in the order of the file.
    pub(crate) fn entries(&self) -> Vec<(&'a str, Place, Value<'a>)> {
        let mut entries: Vec<_> = self
            .table
            .iter()
            .map(|(key, value)| (&**key.get_ref(), self.file.place(key.span()), Value { file: self.file, value }))
            .collect();
        entries.sort_by_key(|(_, place, _)| place.range.start);
        entries
    }

    /// Fails at the first key that is not known.
    pub(crate) fn only(&self, known: &[&str]) -> Result<(), ConfigError> {
        match self.entries().into_iter().find(|(key, _, _)| !known.contains(key)) {
            Some((key, place, _)) => {
                Err(ConfigError::at(place, format!("unknown key `{key}`")).did_you_mean(key, known))
            }
            None => Ok(()),
        }
    }

    /// The value of `key`, or an error at the head of the table.
    pub(crate) fn required(&self, key: &str, what: &str) -> Result<Value<'a>, ConfigError> {
        self.get(key).ok_or_else(|| {
            ConfigError::at(self.place(), format!("`{key}` is missing")).help(format!("add `{key} = {what}`"))
        })
    }
}
