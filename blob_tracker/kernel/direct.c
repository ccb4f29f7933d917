/*
 * Calls compiled kernels without the compiler: looks at the types of the arguments, and jumps.
 *
 * What is called are the wrappers that Numba makes: they take a tuple of Python objects, and trust
 * that these are of the types that they are compiled for. That is told here, exactly: one more
 * dimension, another layout or kind of number, and the call goes on to Kernel.missed.
 *
 * A signature is a row of 32-bit codes, one or more an argument:
 *   ARRAY kind itemsize dimensions layout writable
 *   FLOAT | INTEGER | BOOLEAN | NONE | TEXT
 *   TUPLE class length, then its members; the class is an index of `classes`
 *
 * The machine code stays loaded until the process ends.
 */

#define PY_SSIZE_T_CLEAN
#define NPY_NO_DEPRECATED_API NPY_1_7_API_VERSION
#include <Python.h>
#include <structmember.h>
#include <numpy/arrayobject.h>
#include <numpy/arrayscalars.h>

enum { ARRAY, FLOAT, INTEGER, BOOLEAN, NONE, TEXT, TUPLE };

typedef PyObject *(*Wrapper)(PyObject *, PyObject *, PyObject *);

typedef struct {
    Wrapper wrapper;
    int32_t *codes;
    const int32_t *end;
    PyObject *classes;
    Py_ssize_t arguments;
} Entry;

typedef struct {
    PyObject_HEAD
    Entry *entries;
    Py_ssize_t count;
} Direct;

static int
is_array(PyObject *value, const int32_t *code)
{
    if (!PyArray_CheckExact(value))
        return 0;
    PyArrayObject *array = (PyArrayObject *)value;
    PyArray_Descr *descr = PyArray_DESCR(array);
    int flags = PyArray_FLAGS(array);
    int layout = flags & NPY_ARRAY_C_CONTIGUOUS ? 'C' : flags & NPY_ARRAY_F_CONTIGUOUS ? 'F' : 'A';
    return descr->kind == code[0] && PyArray_ITEMSIZE(array) == code[1]
        && PyArray_NDIM(array) == code[2] && layout == code[3]
        && !!(flags & NPY_ARRAY_WRITEABLE) == code[4]
        && flags & NPY_ARRAY_ALIGNED && PyArray_ISNBO(descr->byteorder);
}

/* Look at one value; move the code on to that of the next. */
static int
is_of(PyObject *value, const int32_t **place, PyObject *classes)
{
    const int32_t *code = *place;
    PyTypeObject *type = Py_TYPE(value);
    *place += 1;
    switch (*code) {
    case ARRAY:
        *place += 5;
        return is_array(value, code + 1);
    case FLOAT:
        return type == &PyFloat_Type || type == &PyDoubleArrType_Type;
    case INTEGER:
        return type == &PyLong_Type || type == &PyLongArrType_Type;
    case BOOLEAN:
        return type == &PyBool_Type || type == &PyBoolArrType_Type;
    case NONE:
        return value == Py_None;
    case TEXT:
        return type == &PyUnicode_Type;
    case TUPLE:
        *place += 2;
        if ((PyObject *)type != PyTuple_GET_ITEM(classes, code[1])
                || !PyTuple_Check(value) || PyTuple_GET_SIZE(value) != code[2])
            return 0;
        for (Py_ssize_t i = 0; i < code[2]; i++)
            if (!is_of(PyTuple_GET_ITEM(value, i), place, classes))
                return 0;
        return 1;
    default:
        return 0;
    }
}

static int
is_for(const Entry *entry, PyObject *arguments)
{
    const int32_t *place = entry->codes;
    if (PyTuple_GET_SIZE(arguments) != entry->arguments)
        return 0;
    for (Py_ssize_t i = 0; i < entry->arguments; i++)
        if (place >= entry->end
                || !is_of(PyTuple_GET_ITEM(arguments, i), &place, entry->classes))
            return 0;
    return place == entry->end;
}

static PyObject *
direct_call(Direct *self, PyObject *arguments, PyObject *keywords)
{
    if (keywords == NULL || PyDict_GET_SIZE(keywords) == 0)
        for (Py_ssize_t i = 0; i < self->count; i++)
            if (is_for(&self->entries[i], arguments))
                return self->entries[i].wrapper(NULL, arguments, NULL);
    PyObject *missed = PyObject_GetAttrString((PyObject *)self, "missed");
    if (missed == NULL)
        return NULL;
    PyObject *result = PyObject_Call(missed, arguments, keywords);
    Py_DECREF(missed);
    return result;
}

/* Tell whether a row of codes holds so many values, and no index is beyond the classes. */
static int
is_whole(const int32_t **place, const int32_t *end, Py_ssize_t values, Py_ssize_t classes)
{
    while (values-- > 0) {
        const int32_t *code = *place;
        Py_ssize_t length = code >= end ? 1 : *code == ARRAY ? 6 : *code == TUPLE ? 3 : 1;
        if (end - code < length || *code < ARRAY || *code > TUPLE)
            return 0;
        *place += length;
        if (*code == TUPLE && (code[1] < 0 || code[1] >= classes || code[2] < 0
                || !is_whole(place, end, code[2], classes)))
            return 0;
    }
    return 1;
}

static PyObject *
direct_add(Direct *self, PyObject *arguments)
{
    const char *codes;
    Py_ssize_t length, values;
    PyObject *classes;
    unsigned long long address;
    if (!PyArg_ParseTuple(arguments, "y#nO!K", &codes, &length, &values, &PyTuple_Type, &classes,
                          &address))
        return NULL;
    int32_t *copied = PyMem_Malloc(length + sizeof(int32_t));
    if (copied == NULL)
        return PyErr_NoMemory();
    memcpy(copied, codes, length);
    const int32_t *place = copied, *end = copied + length / sizeof(int32_t);
    if (!is_whole(&place, end, values, PyTuple_GET_SIZE(classes)) || place != end || !address) {
        PyMem_Free(copied);
        PyErr_SetString(PyExc_ValueError, "no signature");
        return NULL;
    }
    Entry *entries = PyMem_Realloc(self->entries, (self->count + 1) * sizeof(Entry));
    if (entries == NULL) {
        PyMem_Free(copied);
        return PyErr_NoMemory();
    }
    Py_INCREF(classes);
    self->entries = entries;
    entries[self->count++] = (Entry){
        (Wrapper)(uintptr_t)address, copied, end, classes, values,
    };
    Py_RETURN_NONE;
}

static void
direct_dealloc(Direct *self)
{
    for (Py_ssize_t i = 0; i < self->count; i++) {
        PyMem_Free(self->entries[i].codes);
        Py_DECREF(self->entries[i].classes);
    }
    PyMem_Free(self->entries);
    PyTypeObject *type = Py_TYPE(self);
    type->tp_free((PyObject *)self);
}

static PyMethodDef direct_methods[] = {
    {"add", (PyCFunction)direct_add, METH_VARARGS,
     "add(codes, values, classes, address): call this wrapper for arguments of these types."},
    {NULL},
};

static PyMemberDef direct_members[] = {
    {"count", T_PYSSIZET, offsetof(Direct, count), READONLY, "How many signatures are served."},
    {NULL},
};

static PyTypeObject DirectType = {
    PyVarObject_HEAD_INIT(NULL, 0)
    .tp_name = "blob_tracker.kernel.direct.Direct",
    .tp_basicsize = sizeof(Direct),
    .tp_flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_BASETYPE,
    .tp_doc = "Calls machine code for the types of arguments that it knows, else `missed`.",
    .tp_new = PyType_GenericNew,
    .tp_dealloc = (destructor)direct_dealloc,
    .tp_call = (ternaryfunc)direct_call,
    .tp_methods = direct_methods,
    .tp_members = direct_members,
};

static PyObject *unpickled;  /* by the place of what is pickled: as Numba keeps it */

/* In place of Numba's, which imports Numba. */
static PyObject *
unpickle(const char *data, int length, const char *digest)
{
    PyObject *key = PyLong_FromVoidPtr((void *)data);
    if (key == NULL)
        return NULL;
    PyObject *found = PyDict_GetItemWithError(unpickled, key);
    Py_XINCREF(found);
    if (found == NULL && !PyErr_Occurred()) {
        PyObject *pickle = PyImport_ImportModule("pickle");
        if (pickle != NULL) {
            found = PyObject_CallMethod(pickle, "loads", "y#", data, (Py_ssize_t)length);
            Py_DECREF(pickle);
        }
        if (found != NULL && PyDict_SetItem(unpickled, key, found) < 0)
            Py_CLEAR(found);
    }
    Py_DECREF(key);
    return found;
}

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "direct", "Calls compiled kernels without the compiler.", -1,
};

PyMODINIT_FUNC
PyInit_direct(void)
{
    import_array();
    unpickled = PyDict_New();
    if (unpickled == NULL || PyType_Ready(&DirectType) < 0)
        return NULL;
    PyObject *module = PyModule_Create(&definition);
    if (module == NULL)
        return NULL;
    Py_INCREF(&DirectType);
    if (PyModule_AddObject(module, "Direct", (PyObject *)&DirectType) < 0
            || PyModule_AddObject(module, "UNPICKLE", PyLong_FromVoidPtr(unpickle)) < 0) {
        Py_DECREF(module);
        return NULL;
    }
    return module;
}
