/* Blocks of text from standard input, each read from memory of exactly its size. */

#include "plain.c"
#include <stdio.h>
#include <stdlib.h>

static int take(void *to, size_t size) { return fread(to, 1, size, stdin) == size; }

int main(void)
{
    static ten tens[-LOWEST_POWER];
    uint64_t head[4]; /* length, delimiter, rows, width */
    if (!take(tens, sizeof tens))
        return 1;
    while (take(head, sizeof head)) {
        const size_t count = head[2] * head[3];
        letter *text = malloc(head[0] ? head[0] : 1);
        double *values = malloc(count ? count * sizeof *values : 1);
        if (!text || !values || !take(text, head[0]))
            return 1;
        const int status = read_numbers(text, head[0], (int)head[1], head[2], head[3], tens, values);
        fputc(status, stdout);
        if (status == FOUND)
            fwrite(values, sizeof *values, count, stdout);
        free(values);
        free(text);
    }
    return 0;
}
