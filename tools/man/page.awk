# Turns `toliman COMMAND --help` into a page of man(7): the text before "Usage:" is the description and the examples, the
# lists after it are arguments, options and commands. Variables: name (of the page), version, tail (a file, may be missing).

# A line of text in roff: hyphens are minus signs, and no line is a request.
function plain(text) {
    gsub(/\\/, "\\\\e", text)
    gsub(/-/, "\\\\-", text)
    return (text ~ /^[.']/ ? "\\&" : "") text
}

function bold(text) { return "\\fB" plain(text) "\\fR" }

# Text in which `words` and --options are bold.
function marked(text,    out) {
    while (match(text, /`[^`]*`|--[a-z][a-z0-9-]*/)) {
        out = out plain(substr(text, 1, RSTART - 1))
        found = substr(text, RSTART, RLENGTH)
        gsub(/`/, "", found)
        text = substr(text, RSTART + RLENGTH)
        out = out bold(found)
    }
    return out plain(text)
}

# Removes "Excludes: --a --b" from the global `head` and returns "Not with --a, --b."
function relation(key, words,    list) {
    if (!match(head, " " key ": .*"))
        return ""
    list = substr(head, RSTART + length(key) + 3)
    head = substr(head, 1, RSTART - 1)
    gsub(/ /, ", ", list)
    return ". " words " " list "."
}

# Adds the list entry that was collected in `head` and `text` to its section, and what is required to the synopsis.
function end_entry(    required, more) {
    if (head == "")
        return
    more = relation("Excludes", "Not with")
    more = relation("Needs", "Only with") more
    required = sub(/ REQUIRED/, "", head)
    sub(/ \.\.\.$/, "", head)
    if (match(head, /,\.\.\.:\{.*\}/)) { # a list "NAME,...:{a,b}"
        more = ". Of " substr(head, RSTART + 6, RLENGTH - 7) "." more
        head = substr(head, 1, RSTART + 3)
    }
    sub(/[A-Z]+:/, "", head) # "TEXT:{a,b}" is "{a,b}"
    if (list == "COMMANDS")
        head = bold("toliman-" head) "(1)"
    else if (match(head, /-[^ ]*/) == 1) {
        more = text more
        text = substr(head, RLENGTH + 2)
        head = substr(head, 1, RLENGTH)
        sub(/,/, ", ", head)
        head = bold(head) (text == "" ? "" : " \\fI" plain(text) "\\fR")
        text = more
        more = ""
        if (required)
            synopsis = synopsis " " head
    } else {
        head = "\\fI" plain(head) "\\fR"
        arguments = arguments " " (required ? head : "[" head "]")
    }
    lists[list] = lists[list] ".TP\n" head "\n" marked(text more) "\n"
    head = ""
}

# Adds the paragraph that was collected in `text` to the description.
function end_paragraph() {
    body = body (text == "" ? "" : ".PP\n" marked(text) "\n")
    text = ""
}

function section(title, text) {
    if (text != "")
        printf ".SH %s\n%s", title, text
}

NR == 1 && $0 == "" { next }
summary == "" { summary = $0; next }
/^Examples?:$/ { in_examples = 1; next }
in_examples && /^  / { examples = examples plain(substr($0, 3)) "\n"; next }
/^Usage: / { end_paragraph(); usage = $0; next }
/^(Positionals|Options|Subcommands):$/ {
    end_entry()
    list = $1 == "Options:" ? "OPTIONS" : $1 == "Positionals:" ? "ARGUMENTS" : "COMMANDS"
    next
}
usage == "" {
    in_examples = 0
    if (/^ /) { # a table or an equation
        end_paragraph()
        body = body (in_table ? "" : ".PP\n.nf\n") plain($0) "\n"
    } else {
        body = body (in_table ? ".fi\n" : "")
        if ($0 == "")
            end_paragraph()
        text = text (text == "" ? "" : " ") $0
    }
    in_table = /^ /
    next
}
/^  [^ ]/ { # the head of an entry, and its text after two or more spaces if there is space
    end_entry()
    head = substr($0, 3)
    text = ""
    if (match(head, /  +/)) {
        text = substr(head, RSTART + RLENGTH)
        head = substr(head, 1, RSTART - 1)
    }
    next
}
/^   / { sub(/^ +/, ""); text = text (text == "" ? "" : " ") $0 }

END {
    end_entry()
    if (usage == "")
        exit 1
    if (summary ~ /^.[a-z]/)
        summary = tolower(substr(summary, 1, 1)) substr(summary, 2)
    sub(/\.$/, "", summary)
    typed = name
    sub(/-/, " ", typed)
    printf ".TH %s 1 \"\" \"libtoliman %s\" \"User Commands\"\n", toupper(name), version
    section("NAME", plain(name) " \\- " plain(summary) "\n")
    more = lists["COMMANDS"] == "" ? "" : " \\fIcommand\\fR ..."
    section("SYNOPSIS", bold(typed) " [\\fIoptions\\fR]" synopsis arguments more "\n")
    section("DESCRIPTION", body)
    for (i = split("COMMANDS ARGUMENTS OPTIONS", titles); i > 0; i--)
        order[i] = titles[i]
    for (i = 1; i <= 3; i++)
        section(order[i], lists[order[i]])
    section("EXAMPLES", ".nf\n" examples ".fi\n")
    while (tail != "" && (getline line < tail) > 0)
        print line
    if (name != "toliman")
        section("SEE ALSO", "\\fBtoliman\\fR(1), \\fBlibtoliman\\fR(3)\n")
}
