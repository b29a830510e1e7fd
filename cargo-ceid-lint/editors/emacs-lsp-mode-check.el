;;; Drives the language server with lsp-mode, without a window, and prints what it shows of a file.
;;
;;   CEID_LINT=target/debug/cargo-ceid-lint CEID_FILE=fixtures/workspaces/figure3_legacy/src/control.rs \
;;     emacs --batch -l cargo-ceid-lint/editors/emacs-lsp-mode-check.el
;;
;; Needs lsp-mode and rust-mode. With CEID_BESIDE=1, rust-analyzer serves the file too; then it has to be on PATH.

(package-initialize)
(require 'lsp-mode)
(require 'rust-mode)

(setq lsp-session-file (make-temp-name (expand-file-name "lsp-session-" temporary-file-directory))
      lsp-auto-guess-root t
      lsp-keep-workspace-alive nil
      lsp-enable-file-watchers nil
      lsp-enable-snippet nil
      lsp-diagnostics-provider :none
      lsp-enabled-clients (if (getenv "CEID_BESIDE") '(rust-analyzer ceid-lint) '(ceid-lint)))

(lsp-register-client
 (make-lsp-client :new-connection (lsp-stdio-connection (list (expand-file-name (getenv "CEID_LINT")) "lsp"))
                  :activation-fn (lsp-activate-on "rust")
                  :add-on? t
                  :server-id 'ceid-lint))

(defun ceid-findings ()
  "What the editor knows of the buffer, first line first."
  (sort (cl-remove-if-not (lambda (finding) (equal (lsp:diagnostic-source? finding) "ceid-lint"))
                          (gethash (lsp--fix-path-casing buffer-file-name) (lsp-diagnostics)))
        (lambda (one other) (< (ceid-line one) (ceid-line other)))))

(defun ceid-line (finding)
  "The line of FINDING."
  (1+ (lsp:position-line (lsp:range-start (lsp:diagnostic-range finding)))))

(defun ceid-print (title)
  "Print the findings under TITLE."
  (princ (format "%s: %d\n" title (length (ceid-findings))))
  (dolist (finding (ceid-findings))
    (princ (format "  %d: %s\n" (ceid-line finding) (car (split-string (lsp:diagnostic-message finding) "\n"))))
    (mapc (lambda (step) (princ (format "    %s\n" (lsp:diagnostic-related-information-message step))))
          (lsp:diagnostic-related-information? finding))))

(defun ceid-await (holds what)
  "Wait until HOLDS, or fail because WHAT was not seen."
  (let ((until (+ (float-time) 120)))
    (while (and (not (funcall holds)) (< (float-time) until))
      (accept-process-output nil 0.1))
    (unless (funcall holds)
      (message "not seen: %s" what)
      (kill-emacs 1))))

(find-file (getenv "CEID_FILE"))
(rust-mode)
(buffer-enable-undo)
(lsp)
(ceid-await #'ceid-findings "a finding")
(ceid-print "findings")

;; The suppression, done as the editor does it, and undone.
(let ((count (length (ceid-findings))))
  (goto-char (point-min))
  (forward-line (1- (ceid-line (car (ceid-findings)))))
  (back-to-indentation)
  (undo-boundary)
  (let ((suppression (cl-find-if (lambda (action) (string-prefix-p "suppress" (lsp:code-action-title action)))
                                 (append (lsp-code-actions-at-point) nil))))
    (lsp-execute-code-action suppression))
  (ceid-await (lambda () (= (length (ceid-findings)) (1- count))) "one finding less after the suppression")
  (ceid-print "after the suppression")
  (undo-boundary)
  (undo)
  (ceid-await (lambda () (= (length (ceid-findings)) count)) "the finding again after undo")
  (ceid-print "after undo"))
(set-buffer-modified-p nil)
(kill-emacs 0)
