//! JSON-RPC: what a message is, and what is answered to one that is none.

use serde_json::{Value, json};

/// A message from the client, as far as it is one.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Incoming {
    /// Wants an answer.
    Request {
        /// Comes back with the answer.
        id: Value,
        /// What is asked.
        method: String,
        /// About what; null if there is nothing.
        params: Value,
    },
    /// Wants none.
    Notification {
        /// What happened.
        method: String,
        /// To what.
        params: Value,
    },
    /// Answers a request of ours.
    Response {
        /// The number of the request.
        id: Value,
        /// The result, or the client's error.
        result: Result<Value, Value>,
    },
    /// Nothing that could be understood.
    Invalid {
        /// The request it may have been; null if that cannot be told.
        id: Value,
        /// What is wrong with it.
        error: RequestError,
    },
    /// The client has hung up.
    End,
}

/// Why a request has no result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct RequestError {
    /// The protocol's number for it.
    pub(super) code: i32,
    /// What is wrong.
    pub(super) message: String,
}

impl RequestError {
    pub(super) const PARSE_ERROR: i32 = -32700;
    pub(super) const INVALID_REQUEST: i32 = -32600;
    pub(super) const METHOD_NOT_FOUND: i32 = -32601;
    pub(super) const INVALID_PARAMS: i32 = -32602;
    pub(super) const INTERNAL_ERROR: i32 = -32603;
    pub(super) const NOT_INITIALIZED: i32 = -32002;
    pub(super) const CANCELLED: i32 = -32800;

    pub(super) fn new(code: i32, message: impl Into<String>) -> Self {
        Self { code, message: message.into() }
    }

    pub(super) fn invalid_params(method: &str, error: &serde_json::Error) -> Self {
        Self::new(Self::INVALID_PARAMS, format!("wrong parameters of `{method}`: {error}"))
    }
}

impl Incoming {
    /// Reads the body of a message.
    pub(super) fn read(body: &[u8]) -> Self {
        match serde_json::from_slice(body) {
            Ok(value) => Self::of_value(value),
            Err(error) => Self::invalid(RequestError::PARSE_ERROR, format!("the message is not JSON: {error}")),
        }
    }

    /// A message that could not be understood, from nobody knows which request.
    pub(super) fn invalid(code: i32, message: impl Into<String>) -> Self {
        Self::Invalid { id: Value::Null, error: RequestError::new(code, message) }
    }

    fn of_value(mut value: Value) -> Self {
        let invalid = |message: &str| Self::invalid(RequestError::INVALID_REQUEST, message);
        let Some(object) = value.as_object_mut() else { return invalid("a message is an object") };
        let id = object.remove("id");
        let is_id = |id: &Value| id.is_string() || id.is_i64() || id.is_u64();
        match (object.remove("method"), id) {
            (Some(Value::String(method)), None) => {
                Self::Notification { method, params: object.remove("params").unwrap_or_default() }
            }
            (Some(Value::String(method)), Some(id)) if is_id(&id) => {
                Self::Request { id, method, params: object.remove("params").unwrap_or_default() }
            }
            (Some(Value::String(_)), Some(_)) => invalid("the id of a request is a whole number or a string"),
            (None, Some(id)) if object.contains_key("result") || object.contains_key("error") => {
                let result =
                    object.remove("error").map_or_else(|| Ok(object.remove("result").unwrap_or_default()), Err);
                Self::Response { id, result }
            }
            (_, Some(id)) if is_id(&id) => {
                let error = RequestError::new(RequestError::INVALID_REQUEST, "a request has a method");
                Self::Invalid { id, error }
            }
            _ => invalid("neither a request nor an answer"),
        }
    }
}

/// The answer to a request.
pub(super) fn response(id: &Value, result: Result<Value, RequestError>) -> Value {
    match result {
        Ok(result) => json!({ "jsonrpc": "2.0", "id": id, "result": result }),
        Err(RequestError { code, message }) => {
            json!({ "jsonrpc": "2.0", "id": id, "error": { "code": code, "message": message } })
        }
    }
}

/// A notification for the client.
pub(super) fn notification(method: &str, params: &Value) -> Value {
    json!({ "jsonrpc": "2.0", "method": method, "params": params })
}

/// A request to the client.
pub(super) fn request(id: u64, method: &str, params: &Value) -> Value {
    let mut message = json!({ "jsonrpc": "2.0", "id": id, "method": method });
    // A request without parameters has no such field: null is not allowed there.
    if !params.is_null() {
        message["params"] = params.clone();
    }
    message
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_invalid(body: &str, expected_id: &Value, expected_code: i32) {
        let Incoming::Invalid { id, error } = Incoming::read(body.as_bytes()) else { panic!("{body} is understood") };
        assert_eq!((&id, error.code), (expected_id, expected_code));
    }

    #[test]
    fn the_three_kinds_are_told_apart() {
        assert_eq!(
            Incoming::read(br#"{"id": "a", "method": "shutdown"}"#),
            Incoming::Request { id: json!("a"), method: "shutdown".to_owned(), params: Value::Null }
        );
        assert_eq!(
            Incoming::read(br#"{"method": "exit", "params": null}"#),
            Incoming::Notification { method: "exit".to_owned(), params: Value::Null }
        );
        assert_eq!(
            Incoming::read(br#"{"id": 1, "result": null}"#),
            Incoming::Response { id: json!(1), result: Ok(Value::Null) }
        );
    }

    #[test]
    fn what_is_wrong_is_told_by_its_code() {
        check_invalid("{", &Value::Null, RequestError::PARSE_ERROR);
        check_invalid("\u{fffd}", &Value::Null, RequestError::PARSE_ERROR);
        check_invalid("[]", &Value::Null, RequestError::INVALID_REQUEST);
        check_invalid("{}", &Value::Null, RequestError::INVALID_REQUEST);
        check_invalid(r#"{"id": 7}"#, &json!(7), RequestError::INVALID_REQUEST);
        check_invalid(r#"{"id": 7, "method": 8}"#, &json!(7), RequestError::INVALID_REQUEST);
        check_invalid(r#"{"id": 1.5, "method": "a"}"#, &Value::Null, RequestError::INVALID_REQUEST);
        check_invalid(r#"{"id": null, "method": "a"}"#, &Value::Null, RequestError::INVALID_REQUEST);
    }
}
