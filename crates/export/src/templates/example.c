{{header}}
/* Inputs on stdin, a column each by name, to states on stdout; the initial state as arguments:
 *
 *   cc -std=c99 -O2 -ffp-contract=off -o {{base}} {{base}}.c {{base}}_example.c -lm
 *   ./{{base}} U V R < inputs.csv > states.csv
 */
#include "{{base}}.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LONGEST 65536
#define COLUMNS 1024

/* Cuts `line` at its commas, at most COLUMNS of them. */
static int cut(char *line, char **cells)
{
    int count = 0;
    line[strcspn(line, "\r\n")] = '\0';
    while (count < COLUMNS) {
        char *comma = strchr(line, ',');
        cells[count++] = line + strspn(line, " ");
        if (!comma) {
            break;
        }
        *comma = '\0';
        line = comma + 1;
    }
    return count;
}

int main(int count, char **words)
{
    static char line[LONGEST];
    static char *cells[COLUMNS];
    int places[{{BASE}}_INPUTS + 1];
    double input[{{BASE}}_INPUTS + 1] = {0.0};
    double state[{{BASE}}_STATES] = {0.0};
    int columns, i, k;
    for (i = 0; i < {{BASE}}_STATES && i + 1 < count; i++) {
        state[i] = strtod(words[i + 1], NULL);
    }
    if (!fgets(line, sizeof line, stdin)) {
        line[0] = '\0';
    }
    columns = cut(line, cells);
    for (i = 0; i < {{BASE}}_INPUTS; i++) {
        const char *name = {{base}}_channels[{{BASE}}_STATES + i].identifier;
        places[i] = 0;
        while (places[i] < columns && strcmp(cells[places[i]], name) != 0) {
            places[i]++;
        }
        if (places[i] == columns) {
            fprintf(stderr, "stdin: found no column %s, expected one for every input; add it\n", name);
            return 3;
        }
    }
    printf("t,u,v,r\n");
    for (k = 0;; k++) {
        printf("%.17g,%.17g,%.17g,%.17g\n", k * {{BASE}}_STEP_S, state[0], state[1], state[2]);
        if (!fgets(line, sizeof line, stdin)) {
            return 0;
        }
        if (cut(line, cells) != columns) {
            fprintf(stderr, "stdin: row %d: found another number of cells than columns; correct it\n", k + 1);
            return 3;
        }
        for (i = 0; i < {{BASE}}_INPUTS; i++) {
            char *end;
            input[i] = strtod(cells[places[i]], &end);
            if (end == cells[places[i]]) {
                fprintf(stderr, "stdin: row %d: found `%s`, expected a number; correct it\n", k + 1, end);
                return 3;
            }
        }
        {{base}}_step(state, input, NULL, state);
    }
}
