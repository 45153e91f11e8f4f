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

/* Where `name` stands among the columns; their number where it does not. */
static int place_of(const char *name, char **cells, int columns)
{
    int place = 0;
    while (place < columns && strcmp(cells[place], name) != 0) {
        place++;
    }
    return place;
}

/* Whether a column that is no input has times under another name than `t`, or in another unit. */
static int is_time(const char *name)
{
    static const char *const starts[] = {"time", "Time", "TIME", "stamp", "second", "t [", "t ("};
    static const char *const whole[] = {"T", "t_s", "t_ms", "t_us", "t_ns"};
    size_t k;
    for (k = 0; k < sizeof starts / sizeof *starts; k++) {
        if (strncmp(name, starts[k], strlen(starts[k])) == 0) {
            return 1;
        }
    }
    for (k = 0; k < sizeof whole / sizeof *whole; k++) {
        if (strcmp(name, whole[k]) == 0) {
            return 1;
        }
    }
    return 0;
}

static int number(const char *cell, long row, double *value)
{
    char *end;
    *value = strtod(cell, &end);
    if (end == cell) {
        fprintf(stderr, "stdin: row %ld: found `%s`, expected a number; correct it\n", row, cell);
    }
    return end != cell;
}

int main(int count, char **words)
{
    static char line[LONGEST];
    static char *cells[COLUMNS];
    /* The inputs, then the time. */
    int places[{{BASE}}_INPUTS + 1];
    double row[{{BASE}}_INPUTS + 1];
    double state[{{BASE}}_STATES] = {0.0};
    double *rows = NULL;
    double start_s = 0.0;
    long room = 0, length = 0, k;
    int columns, timed = 1, i;
    for (i = 0; i < {{BASE}}_STATES && i + 1 < count; i++) {
        state[i] = strtod(words[i + 1], NULL);
    }
    if (!fgets(line, sizeof line, stdin)) {
        line[0] = '\0';
    }
    /* A mark of the byte order may come first. */
    columns = cut(strncmp(line, "\xEF\xBB\xBF", 3) == 0 ? line + 3 : line, cells);
    for (i = 0; i < {{BASE}}_INPUTS; i++) {
        const char *name = {{base}}_channels[{{BASE}}_STATES + i].identifier;
        places[i] = place_of(name, cells, columns);
        if (places[i] == columns) {
            fprintf(stderr, "stdin: found no column %s, expected one for every input; add it\n", name);
            return 3;
        }
        timed = timed && strcmp(name, "t") != 0;
    }
    places[{{BASE}}_INPUTS] = place_of("t", cells, columns);
    timed = timed && places[{{BASE}}_INPUTS] < columns;
    for (k = 0; k < columns && !timed; k++) {
        for (i = 0; i < {{BASE}}_INPUTS && places[i] != k; i++) {
        }
        if (i == {{BASE}}_INPUTS && is_time(cells[k])) {
            fprintf(stderr, "stdin: found column %s, expected times as `t`, in seconds, or none; rename or remove it\n", cells[k]);
            return 3;
        }
    }
    /* The whole table is read first: one that is refused has no states. */
    while (fgets(line, sizeof line, stdin)) {
        if (line[strspn(line, " \r\n")] == '\0') {
            continue;
        }
        if (cut(line, cells) != columns) {
            fprintf(stderr, "stdin: row %ld: found another number of cells than columns; correct it\n", length + 1);
            return 3;
        }
        for (i = 0; i < {{BASE}}_INPUTS + timed; i++) {
            if (!number(cells[places[i]], length + 1, row + i)) {
                return 3;
            }
        }
        if (timed) {
            const double time_s = row[{{BASE}}_INPUTS];
            const double off = (time_s - (start_s = length ? start_s : time_s)) * {{BASE}}_SAMPLE_RATE_HZ - (double)length;
            if (!(off < 1e-3 && off > -1e-3)) {
                fprintf(stderr,
                        "stdin: row %ld: found t = %g s, expected %g s, rows %g s apart as the model steps; resample the table, or "
                        "export the model by --rate for its step\n",
                        length + 1, time_s, start_s + (double)length * {{BASE}}_STEP_S, {{BASE}}_STEP_S);
                return 3;
            }
        }
        if (length == room) {
            double *more = realloc(rows, (size_t)(room = 2 * room + 1024) * sizeof row);
            if (!more) {
                fprintf(stderr, "stdin: found more rows than memory holds; cut the table\n");
                return 3;
            }
            rows = more;
        }
        memcpy(rows + (size_t)length++ * ({{BASE}}_INPUTS + 1), row, sizeof row);
    }
    printf("t,u,v,r\n");
    for (k = 0;; k++) {
        printf("%.17g,%.17g,%.17g,%.17g\n", (double)k * {{BASE}}_STEP_S, state[0], state[1], state[2]);
        if (k == length) {
            free(rows);
            return 0;
        }
        {{base}}_step(state, rows + (size_t)k * ({{BASE}}_INPUTS + 1), NULL, state);
    }
}
