;;; Drives the language server with Emacs' own client (eglot), without a window, and prints what it shows of a file.
;;
;;   CEID_LINT=target/debug/cargo-ceid-lint CEID_FILE=fixtures/workspaces/figure3_legacy/src/control.rs \
;;     emacs --batch -l cargo-ceid-lint/editors/emacs-check.el
;;
;; Needs eglot (part of Emacs 29; before that, a package) and rust-mode.

(package-initialize)
(require 'eglot)
(require 'rust-mode)
(require 'flymake)

(setq eglot-sync-connect 60
      eglot-autoshutdown t
      eglot-server-programs
      (list (list '(rust-mode) (expand-file-name (getenv "CEID_LINT")) "lsp")))

(defun ceid-findings ()
  "What the editor shows of the buffer, as lines of text."
  (mapcar (lambda (finding)
            (format "  %d: %s"
                    (line-number-at-pos (flymake-diagnostic-beg finding))
                    (car (split-string (flymake-diagnostic-text finding) "\n"))))
          (flymake-diagnostics)))

(defun ceid-await (holds what)
  "Wait until HOLDS, or fail because WHAT was not seen."
  (let ((until (+ (float-time) 60)))
    (while (and (not (funcall holds)) (< (float-time) until))
      (accept-process-output nil 0.1)
      (flymake-start))
    (unless (funcall holds)
      (message "not seen: %s" what)
      (kill-emacs 1))))

(defun ceid-print (title)
  "Print the findings under TITLE."
  (princ (format "%s: %d\n%s\n" title (length (ceid-findings)) (string-join (ceid-findings) "\n"))))

(find-file (getenv "CEID_FILE"))
(rust-mode)
(eglot-ensure)
(apply #'eglot (eglot--guess-contact))
(ceid-await (lambda () (ceid-findings)) "a finding")
(ceid-print "findings")

;; An innocent edit moves them; taking them away is done by an empty text.
(let ((text (buffer-string)))
  (goto-char (point-min))
  (insert "// é𝛼\n")
  (eglot--signal-textDocument/didChange)
  (ceid-await (lambda () (cl-some (lambda (line) (string-match-p "^  37: " line)) (ceid-findings)))
              "the findings one line below")
  (ceid-print "after an edit")
  (erase-buffer)
  (eglot--signal-textDocument/didChange)
  (ceid-await (lambda () (not (ceid-findings))) "nothing, in an empty text")
  (ceid-print "after the text is gone"))
(set-buffer-modified-p nil)
(eglot-shutdown (eglot-current-server))
(kill-emacs 0)
