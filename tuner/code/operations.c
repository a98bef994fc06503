/* Operations on many numbers at once. Before this text tuner/code/calculator.py writes their codes,
 * and after it that of runs.c. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define EACH(result) for (size_t i = 0; i < width; i++) out[i] = (result); break

static double whole(double x)
{
    return isnan(x) ? 0.0 : fmin(fmax(trunc(x), -2147483648.0), 2147483647.0);
}

static double whole_quotient(double x, double y)
{
    const double q = trunc(x / y);
    return isfinite(q) ? q : 0.0;
}

static void apply(int op, const double *x, const double *y, const double *z, double *out,
                  size_t width)
{
    switch (op) {
    case NEG: EACH(-x[i]);
    case NOT: EACH(x[i] == 0.0);
    case IS_FINITE: EACH(isfinite(x[i]) != 0);
    case ISNAN: EACH(isnan(x[i]) != 0);
    case ABS: EACH(fabs(x[i]));
    case SQRT: EACH(sqrt(x[i]));
    case CBRT: EACH(cbrt(x[i]));
    case SIN: EACH(sin(x[i]));
    case COS: EACH(cos(x[i]));
    case TAN: EACH(tan(x[i]));
    case ASIN: EACH(asin(x[i]));
    case ACOS: EACH(acos(x[i]));
    case ATAN: EACH(atan(x[i]));
    case SINH: EACH(sinh(x[i]));
    case COSH: EACH(cosh(x[i]));
    case TANH: EACH(tanh(x[i]));
    case ASINH: EACH(asinh(x[i]));
    case ACOSH: EACH(acosh(x[i]));
    case ATANH: EACH(atanh(x[i]));
    case EXP: EACH(exp(x[i]));
    case EXP2: EACH(exp2(x[i]));
    case EXPM1: EACH(expm1(x[i]));
    case LOG: EACH(log(x[i]));
    case LOG1P: EACH(log1p(x[i]));
    case FLOOR: EACH(floor(x[i]));
    case CEIL: EACH(ceil(x[i]));
    case ROUND: EACH(rint(x[i]));
    case ERF: EACH(erf(x[i]));
    case ERFC: EACH(erfc(x[i]));
    case LGAMMA: EACH(lgamma(x[i]));
    case ADD: EACH(x[i] + y[i]);
    case SUB: EACH(x[i] - y[i]);
    case MUL: EACH(x[i] * y[i]);
    case DIV: EACH(x[i] / y[i]);
    case REM: EACH(fmod(x[i], y[i]));
    case POW: EACH(pow(x[i], y[i]));
    case ATAN2: EACH(atan2(x[i], y[i]));
    case MAX: EACH(x[i] >= y[i] || isnan(x[i]) ? x[i] : y[i]);
    case MIN: EACH(x[i] <= y[i] || isnan(x[i]) ? x[i] : y[i]);
    case EQ: EACH(x[i] == y[i]);
    case NE: EACH(x[i] != y[i]);
    case LT: EACH(x[i] < y[i]);
    case LE: EACH(x[i] <= y[i]);
    case GT: EACH(x[i] > y[i]);
    case GE: EACH(x[i] >= y[i]);
    case AND: EACH((x[i] != 0.0) & (y[i] != 0.0));
    case OR: EACH((x[i] != 0.0) | (y[i] != 0.0));
    case XOR: EACH((x[i] != 0.0) != (y[i] != 0.0));
    case CHOOSE: EACH(x[i] != 0.0 ? y[i] : z[i]);
    case COPY: EACH(x[i]);
    case WHOLE: EACH(whole(x[i]));
    case WHOLE_QUOTIENT: EACH(whole_quotient(x[i], y[i]));
    default: break;
    }
}
