/* A filter's step on many states at once: a row for each node, (count, width), in an order in which
 * each follows from those before it; see tuner/code/evaluation.py. Rows without operands are given,
 * the first one among them, which stands where an operation has fewer operands than three. */

/* The other outcome of a decision, or the larger one of what is rounded or added. */
static void apply_otherwise(int op, const double *x, const double *y, const double *z, double *out,
                            size_t width)
{
    switch (op) {
    case MAX: apply(MIN, x, y, z, out, width); break;
    case MIN: apply(MAX, x, y, z, out, width); break;
    case ROUND: EACH(rint(x[i]) + 1.0);
    case ADD: EACH(2.0 * (x[i] + y[i]));
    default:
        apply(op, x, y, z, out, width);
        EACH(out[i] == 0.0);
    }
}

/* All rows. */
void values(size_t count, size_t width, const uint8_t *ops, const int32_t *args, double *rows)
{
    for (size_t k = 0; k < count; k++) {
        const int32_t *a = args + 3 * k;
        if (ops[k] != GIVEN)
            apply(ops[k], rows + a[0] * width, rows + a[1] * width, rows + a[2] * width,
                  rows + k * width, width);
    }
}

/* Some rows, (wanted, whole), a part of the states at a time, so that all rows stay in the cache.
 * Constants stand in the rows already; the inputs are given, (inputs, whole). */
void some_values(size_t count, size_t width, const uint8_t *ops, const int32_t *args, double *rows,
                 size_t whole, size_t inputs, const int32_t *places, const double *given,
                 size_t wanted, const int32_t *ends, double *out)
{
    for (size_t from = 0; from < whole; from += width) {
        const size_t here = whole - from < width ? whole - from : width;
        for (size_t k = 0; k < inputs; k++)
            memcpy(rows + places[k] * width, given + k * whole + from, here * sizeof *rows);
        values(count, width, ops, args, rows);
        for (size_t k = 0; k < wanted; k++)
            memcpy(out + k * whole + from, rows + ends[k] * width, here * sizeof *out);
    }
}

/* Some rows with random rounding errors, (wanted, repeats, width): factors that begin anywhere in
 * a long row of them. */
void noisy(size_t count, size_t width, const uint8_t *ops, const int32_t *args, double *rows,
           size_t repeats, const uint8_t *rounded, const double *errors, const int64_t *begin,
           size_t wanted, const int32_t *ends, double *out)
{
    for (size_t r = 0; r < repeats; r++) {
        const int64_t *next = begin;
        for (size_t k = 0; k < count; k++) {
            const int32_t *a = args + 3 * k;
            double *row = rows + k * width;
            if (ops[k] == GIVEN) continue;
            apply(ops[k], rows + a[0] * width, rows + a[1] * width, rows + a[2] * width, row, width);
            if (!rounded[k]) continue;
            const double *error = errors + *next++ + r * width;
            for (size_t i = 0; i < width; i++) row[i] *= error[i];
        }
        for (size_t k = 0; k < wanted; k++)
            memcpy(out + (k * repeats + r) * width, rows + ends[k] * width, width * sizeof *out);
    }
}

/* One operation with an operand changed by a factor; taken otherwise where there is no operand; or,
 * of a limit, with only the comparison changed. */
static void apply_changed(int op, const double *const given[3], int operand, bool limit, double by,
                          double *out, double *spare, size_t width)
{
    const double *part[3] = {given[0], given[1], given[2]};
    if (operand < 0) {
        apply_otherwise(op, part[0], part[1], part[2], out, width);
        return;
    }
    const double *changed = given[operand], *x = given[1 - (operand == 1)];
    if (limit) {
        for (size_t i = 0; i < width; i++) {
            const double moved = changed[i] * by;
            const bool inside = op == MAX ? x[i] <= moved : x[i] >= moved;
            out[i] = inside ? changed[i] : x[i];
        }
        return;
    }
    for (size_t i = 0; i < width; i++) spare[i] = changed[i] * by;
    part[operand] = spare;
    apply(op, part[0], part[1], part[2], out, width);
}

/* The results, (changes, results, width), where one operation each is changed, and which moved. */
void changed(size_t count, size_t width, const uint8_t *ops, const int32_t *args,
             const double *rows, size_t changes, const int32_t *where, const int8_t *operand,
             const uint8_t *limit, double by, size_t results, const int32_t *ends, double *scratch,
             uint8_t *differs, double *out, uint8_t *moved)
{
    double *spare = scratch + count * width;
    for (size_t m = 0; m < changes; m++) {
        memset(differs, 0, count);
        for (size_t k = where[m]; k < count; k++) {
            const int32_t *a = args + 3 * k;
            const bool own = k == (size_t)where[m];
            if (ops[k] == GIVEN || !(own || differs[a[0]] || differs[a[1]] || differs[a[2]]))
                continue;
            const double *part[3];
            for (int j = 0; j < 3; j++) part[j] = (differs[a[j]] ? scratch : rows) + a[j] * width;
            double *row = scratch + k * width;
            if (own)
                apply_changed(ops[k], part, operand[m], limit[m], by, row, spare, width);
            else
                apply(ops[k], part[0], part[1], part[2], row, width);
            differs[k] = 1;
        }
        for (size_t k = 0; k < results; k++) {
            const double *row = (differs[ends[k]] ? scratch : rows) + ends[k] * width;
            memcpy(out + (m * results + k) * width, row, width * sizeof *out);
            moved[k] |= differs[ends[k]];
        }
    }
}

static double or_zero(double x)
{
    return isfinite(x) ? x : 0.0;
}

/* A weight times the derivative of an operation by one of its operands. */
static void share_of(int op, const double *const part[3], int at, const double *weight, double shift,
                     double *out, double *spare, size_t width)
{
    const double *x = part[0], *y = part[1], *given[3] = {part[0], part[1], part[2]};
    switch (op) {
    case ADD: EACH(weight[i]);
    case SUB: EACH(at == 1 ? -weight[i] : weight[i]);
    case NEG: EACH(-weight[i]);
    case MUL: EACH(weight[i] * or_zero(part[1 - at][i]));
    case DIV: EACH(weight[i] * or_zero(at == 0 ? 1.0 / y[i] : -x[i] / (y[i] * y[i])));
    case CHOOSE: EACH(weight[i] * ((x[i] != 0.0) == (at == 1)));
    default:
        given[at] = spare;
        for (int side = 0; side < 2; side++) {
            for (size_t i = 0; i < width; i++) {
                const double h = shift * fmax(fabs(part[at][i]), shift);
                spare[i] = side ? part[at][i] - h : part[at][i] + h;
            }
            apply(op, given[0], given[1], given[2], spare + (1 + side) * width, width);
        }
        for (size_t i = 0; i < width; i++) {
            const double h = shift * fmax(fabs(part[at][i]), shift);
            out[i] = weight[i] * or_zero((spare[width + i] - spare[2 * width + i]) / (2.0 * h));
        }
    }
}

/* Which rows move, smoothly, with an operand or a result that has a place. */
static void find_moving(size_t count, const int32_t *args, const int8_t *smooth,
                        const int32_t *places, uint8_t *moving)
{
    for (size_t k = 0; k < count; k++) {
        moving[k] = places[4 * k + 3] >= 0;
        for (int at = smooth[2 * k]; at < smooth[2 * k + 1] && !moving[k]; at++)
            moving[k] = places[4 * k + at] >= 0 || moving[args[3 * k + at]];
    }
}

/* Sums of squared moves of weighted results, (places, width), by a change of operands or results,
 * which are given by their places, (count, 4); ranges of operands that a row moves smoothly with. */
void slopes(size_t count, size_t width, const uint8_t *ops, const int32_t *args, const double *rows,
            const int8_t *smooth, const uint8_t *constant, const int32_t *places, size_t weightings,
            size_t results, const int32_t *ends, const double *weights, double change, double shift,
            double *scratch, uint8_t *moving, uint8_t *met, double *squares)
{
    double *share = scratch + count * width, *spare = share + width;
    find_moving(count, args, smooth, places, moving);
    for (size_t w = 0; w < weightings; w++) {
        memset(met, 0, count);
        for (size_t k = 0; k < results; k++, weights += width) {
            double *to = scratch + ends[k] * width;
            for (size_t i = 0; i < width; i++) to[i] = weights[i] + (met[ends[k]] ? to[i] : 0.0);
            met[ends[k]] = 1;
        }
        for (size_t k = count; k-- > 0;) {
            if (!moving[k] || !met[k]) continue;
            const int32_t *a = args + 3 * k, *place = places + 4 * k;
            const double *weight = scratch + k * width;
            const double *part[3];
            for (int j = 0; j < 3; j++) part[j] = rows + a[j] * width;
            for (size_t i = 0; place[3] >= 0 && i < width; i++) {
                const double move = weight[i] * rows[k * width + i] * change;
                squares[place[3] * width + i] += move * move;
            }
            for (int at = smooth[2 * k]; at < smooth[2 * k + 1]; at++) {
                if (place[at] < 0 && !moving[a[at]]) continue;
                share_of(ops[k], part, at, weight, shift, share, spare, width);
                for (size_t i = 0; place[at] >= 0 && i < width; i++) {
                    const double move = share[i] * (change * part[at][i]);
                    squares[place[at] * width + i] += move * move;
                }
                if (constant[a[at]]) continue;
                double *to = scratch + a[at] * width;
                for (size_t i = 0; i < width; i++) to[i] = share[i] + (met[a[at]] ? to[i] : 0.0);
                met[a[at]] = 1;
            }
        }
    }
}
