/* Blocks of text from standard input, each read from memory of exactly its size. */

#include "plain.c"
#include <stdio.h>
#include <stdlib.h>

static int take(void *to, size_t size) { return fread(to, 1, size, stdin) == size; }

static void *room(size_t size)
{
    void *found = malloc(size ? size : 1);
    if (!found)
        exit(2);
    return found;
}

int main(void)
{
    static ten tens[-LOWEST_POWER];
    uint64_t head[6]; /* length, delimiter, point, rows, width, number of wanted columns */
    if (!take(tens, sizeof tens))
        return 1;
    while (take(head, sizeof head)) {
        const size_t count = head[3] * head[5];
        letter *text = room(head[0]);
        int64_t *place = room(head[4] * sizeof *place);
        double *values = room(count * sizeof *values);
        if (!take(place, head[4] * sizeof *place) || !take(text, head[0]))
            return 1;
        const form f = {head[3], head[4], place, (int)head[1], (int)head[2]};
        const int status = read_numbers(text, head[0], &f, tens, values);
        fputc(status, stdout);
        if (status == FOUND)
            fwrite(values, sizeof *values, count, stdout);
        free(values);
        free(place);
        free(text);
    }
    return 0;
}
