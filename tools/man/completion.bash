# Completion of toliman by bash: commands, options and fixed values are those of --help.
_toliman() {
    local program=${1/#\~/$HOME} word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
    local commands command= options line words= head= i
    COMPREPLY=()
    # Bash takes --option=value for three words.
    if [[ $word == = ]]; then
        word=
    elif [[ $before == = ]]; then
        before=${COMP_WORDS[COMP_CWORD - 2]}
    fi
    options=$("$program" --help 2>/dev/null)
    commands="help "$(sed -n '/^Subcommands:/,$s/^  \([a-z][a-z]*\) .*/\1/p' <<< "$options" | tr '\n' ' ')
    for ((i = 1; i < COMP_CWORD; i++)); do
        [[ " $commands" == *" ${COMP_WORDS[i]} "* ]] && command=${COMP_WORDS[i]} && break
    done
    if [[ $command == help ]]; then
        options= words=$commands
    elif [[ -n $command ]]; then
        options=$("$program" "$command" --help 2>/dev/null; grep -e '^  --progress' <<< "$options")
    else
        words=$commands
    fi
    options=$(sed -n '/^Options:/,$s/^ *\(-[a-z],\)\{0,1\}\(--[a-z]\)/\2/p' <<< "$options")
    line=$(grep -e "^$before [A-Z][A-Z,.]" <<< "$options") || : # of an option with a value
    if [[ $line == *:{*}* ]]; then
        words=${line#*:\{} words=${words%%\}*}
        [[ $line == *,...:{* && $word == *,* ]] && head=${word%,*}, word=${word##*,} # of a list
        words=${words//,/ }
    elif [[ -n $line || ( -z $words && $word != -* ) ]]; then
        return 0
    else
        words+=" "$(sed 's/ .*//' <<< "$options")
    fi
    mapfile -t COMPREPLY < <(compgen -P "$head" -W "$words" -- "$word")
}
complete -o default -F _toliman toliman
