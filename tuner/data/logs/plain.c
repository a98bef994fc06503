/* Columns of numbers in lines of text, as the nearest doubles.

   A number is [-+]?(d+.?d*|.d+)([eE][-+]?d+)? with digits d and the decimal mark as its point; an
   empty cell and the word nan are missing ones. Blanks may stand around cells. Up to 2^53 and
   10^22 one rounding of an exact quotient is right (Clinger 1990); beyond, the product with 128
   bits of a power of ten is known to lie between two numbers, and is left to others where both do
   not round alike (Lemire 2021 shows how seldom that is). No library, and so no locale, is asked. */

#include <float.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#if FLT_EVAL_METHOD != 0 || __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "doubles of other widths, or bytes in another order"
#endif

enum status { FOUND, NOT_PLAIN, IN_DOUBT };
enum { MOST_DIGITS = 19, LARGEST_POWER = 15, ONCE = 22, LOWEST_POWER = -290 };
static const uint64_t EXACT = (uint64_t)1 << 53;
static const int64_t ENDLESS = 1000000000000000;

typedef unsigned char letter;
typedef unsigned __int128 wide;

/* A power of ten is between (high 2^64 + low) 2^exponent and one unit of low above. */
typedef struct {
    uint64_t high, low;
    int64_t exponent;
} ten;

/* How a text is written: place is that of each column among the wanted ones, below zero for none. */
typedef struct {
    size_t rows, width;
    const int64_t *place;
    int delimiter, point;
} form;

static const double tens_once[ONCE + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                           1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                           1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

static inline int is_digit(letter c) { return (letter)(c - '0') <= 9; }

/* Eight digits at once, by pairs, fours and eights (Langdale and Lemire 2019). */
static inline int eight_digits(const letter *p, uint64_t *number)
{
    uint64_t v;
    memcpy(&v, p, 8);
    const uint64_t tops = 0xF0F0F0F0F0F0F0F0u;
    if (((v & tops) | (((v + 0x0606060606060606u) & tops) >> 4)) != 0x3333333333333333u)
        return 0;
    v -= 0x3030303030303030u;
    v = v * 10 + (v >> 8);
    v = ((v & 0x000000FF000000FFu) * 0x000F424000000064u +
         ((v >> 16) & 0x000000FF000000FFu) * 0x0000271000000001u) >> 32;
    *number = *number * 100000000 + v;
    return 1;
}

/* Digits up to something else, which a text's last line feed is at the latest. */
static inline const letter *digits_of(const letter *p, const letter *end, uint64_t *number)
{
    while (end - p >= 8 && eight_digits(p, number))
        p += 8;
    for (; is_digit(*p); p++)
        *number = *number * 10 + (*p - '0');
    return p;
}

/* The power of ten behind an e. */
static inline enum status raised(const letter **at, int64_t *power)
{
    const letter *p = *at + 1;
    const int down = *p == '-';
    p += down || *p == '+';
    int64_t found = 0;
    if (!is_digit(*p))
        return NOT_PLAIN;
    for (; is_digit(*p); p++)
        if (found < ENDLESS)
            found = found * 10 + (*p - '0');
    *power = down ? -found : found;
    *at = p;
    return FOUND;
}

/* digits * 10^power, for power below zero. */
static enum status product(uint64_t digits, ten power, double *value)
{
    const int shift = __builtin_clzll(digits);
    const uint64_t whole = digits << shift;
    const wide low = (wide)whole * power.low;
    const wide high = (wide)whole * power.high + (uint64_t)(low >> 64);
    /* The number lies in [high, high + 2) 2^(64 + exponent - shift), with 126 bits or 127 below
       the first. */
    const int below = 74 + (int)(high >> 127);
    const wide rest = high & (((wide)1 << below) - 1), half = (wide)1 << (below - 1);
    if (rest + 2 >= half && rest <= half)
        return IN_DOUBT;
    const uint64_t bits = (uint64_t)(high >> below) + (rest > half);
    const uint64_t two = (uint64_t)(64 + power.exponent - shift + below + 1023) << 52;
    double scale;
    memcpy(&scale, &two, sizeof scale);
    *value = (double)bits * scale;
    return FOUND;
}

static enum status nearest(uint64_t digits, int64_t power, const ten *tens, double *value)
{
    *value = 0.0;
    if (digits == 0)
        return FOUND;
    if (power > LARGEST_POWER || (power >= 0 && digits >= EXACT))
        return NOT_PLAIN;
    if (power < LOWEST_POWER)
        return IN_DOUBT;
    enum status status = FOUND;
    if (power >= 0)
        *value = (double)digits * tens_once[power];
    else if (digits <= EXACT && power >= -ONCE)
        *value = (double)digits / tens_once[-power];
    else
        status = product(digits, tens[power - LOWEST_POWER], value);
    return *value >= (double)EXACT ? NOT_PLAIN : status;
}

/* More digits than 64 bits hold: no number is rounded below what a smaller one is rounded to, so
   that rounding is certain where the first digits, and one more at the last of them, round alike. */
static enum status longer(const letter *p, const letter *end, int mark, int64_t power,
                          const ten *tens, double *value)
{
    uint64_t digits = 0;
    int taken = 0, behind = 0, more = 0;
    for (; p < end; p++) {
        if (*p == mark) {
            behind = 1;
        } else if (taken == MOST_DIGITS) {
            power += !behind;
            more |= *p != '0';
        } else {
            digits = digits * 10 + (*p - '0');
            taken += digits > 0;
            power -= behind;
        }
    }
    double above;
    const enum status status = nearest(digits, power, tens, value);
    if (!more || status != FOUND)
        return status;
    if (nearest(digits + 1, power, tens, &above) != FOUND)
        return IN_DOUBT;
    return above == *value ? FOUND : IN_DOUBT;
}

static enum status missing(const letter **at, const letter *end, double *value)
{
    const letter *p = *at;
    if (end - p < 3 || (p[0] | 0x20) != 'n' || (p[1] | 0x20) != 'a' || (p[2] | 0x20) != 'n')
        return NOT_PLAIN;
    *value = __builtin_nan("");
    *at = p + 3;
    return FOUND;
}

static inline enum status number(const letter **at, const letter *end, int mark, const ten *tens,
                                 double *value)
{
    const letter *p = *at;
    const int minus = *p == '-';
    const letter *first = p += minus || *p == '+';
    uint64_t digits = 0;
    int64_t power = 0;
    for (; is_digit(*p); p++)
        digits = digits * 10 + (*p - '0');
    ptrdiff_t count = p - first;
    if (*p == mark) {
        const letter *point = ++p;
        p = digits_of(p, end, &digits);
        power = point - p;
        count += p - point;
    }
    if (count == 0)
        return missing(at, end, value);
    const letter *behind = p;
    int64_t exponent = 0;
    if ((*p == 'e' || *p == 'E') && raised(&p, &exponent) != FOUND)
        return NOT_PLAIN;
    const enum status status =
        count > MOST_DIGITS ? longer(first, behind, mark, exponent, tens, value)
                            : nearest(digits, power + exponent, tens, value);
    *value = minus ? -*value : *value;
    *at = p;
    return status;
}

static inline const letter *after_blanks(const letter *p, int delimiter)
{
    while (*p <= ' ' && (*p == ' ' || (*p == '\t' && delimiter != '\t')))
        p++;
    return p;
}

/* The end of a cell that is not wanted; its quotes would hide delimiters. */
static const letter *passed(const letter *p, int delimiter)
{
    while (*p != delimiter && *p != '\n' && *p != '"' && !(delimiter == ' ' && *p == '\t'))
        p++;
    return p;
}

/* One cell, up to the blanks behind it. Where blanks are delimiters, none is empty; nor is a line,
   which would be no row. */
static inline enum status cell(const letter **at, const letter *end, const form *f, int64_t place,
                               const ten *tens, double *value)
{
    if (**at == f->delimiter || **at == '\n') {
        if (f->delimiter == ' ' || f->width == 1)
            return NOT_PLAIN;
        *value = __builtin_nan("");
        return FOUND;
    }
    if (place >= 0)
        return number(at, end, f->point, tens, value);
    *at = passed(*at, f->delimiter);
    return **at == '"' ? NOT_PLAIN : FOUND;
}

/* The lines of a whole text; the wanted columns one after another in values. */
int read_numbers(const letter *text, size_t length, const form *f, const ten *tens, double *values)
{
    const letter *p = text, *end = text + length;
    const int delimiter = f->delimiter;
    double none;
    if (length == 0 || end[-1] != '\n' || delimiter == '\n' || delimiter == f->point)
        return NOT_PLAIN;
    for (size_t i = 0; i < f->rows; i++) {
        if (p == end)
            return NOT_PLAIN;
        for (size_t k = 0; k < f->width; k++) {
            const int last = k + 1 == f->width;
            const int64_t place = f->place[k];
            double *value = place < 0 ? &none : &values[(size_t)place * f->rows + i];
            p = after_blanks(p, delimiter);
            if (k == 0 && (*p == '#' || *p == '%'))
                return NOT_PLAIN;
            const enum status status = cell(&p, end, f, place, tens, value);
            if (status != FOUND)
                return status;
            const letter *behind = after_blanks(p, delimiter);
            if (last ? *behind != '\n' : delimiter == ' ' ? behind == p : *behind != delimiter)
                return NOT_PLAIN;
            p = behind + (last || delimiter != ' ');
        }
    }
    return p == end ? FOUND : NOT_PLAIN;
}
